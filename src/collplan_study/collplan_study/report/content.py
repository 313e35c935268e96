"""Content of a report in any format: tables, pictures, and numbers as text."""

from collections.abc import Sequence
from dataclasses import dataclass

from collplan_study.analysis.statistics import Estimate

Row = tuple[str, ...]


@dataclass(frozen=True)
class Picture:
    """A figure that is also a file in the study's folder.

    Attributes:
        svg: the figure.
        file: path of its files in the study's folder, without .png and .svg.
        words: description of it.
    """

    svg: str
    file: str
    words: str


@dataclass(frozen=True)
class Table:
    """A table under its title.

    Attributes:
        title: heading of the table.
        note: how to read it; may be empty.
        head: names of the columns; empty where there is nothing to tabulate.
        rows: text of the cells.
        picture: figure of the same numbers, shown above the table.
        text: whether all columns are text; else all but the first are numbers.
    """

    title: str
    note: str = ""
    head: Row = ()
    rows: Sequence[Row] = ()
    picture: Picture | None = None
    text: bool = False


def with_interval(estimate: Estimate, digits: int, unit: str = "") -> str:
    """Value and interval, or the reason why either is missing."""
    if estimate.value is None:
        return f"none ({estimate.note})"
    value = f"{number(estimate.value, digits)}{unit}"
    if estimate.low is None or estimate.high is None:
        return f"{value} ({estimate.note})"
    return f"{value} [{number(estimate.low, digits)}, {number(estimate.high, digits)}]"


def number(value: float | None, digits: int) -> str:
    """A number with fixed digits, or "none"."""
    # + 0.0: no minus before a zero
    return "none" if value is None else f"{round(value, digits) + 0.0:.{digits}f}"
