"""Content of a report in any format: sections, tables, pictures, and numbers as text."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from collplan_study.analysis.statistics import Estimate

Row = tuple[str, ...]


@dataclass(frozen=True)
class Picture:
    """A figure that is also a file in the study's folder.

    Attributes:
        svg: the figure.
        words: description of it.
        caption: the line below it.
    """

    svg: str
    words: str
    caption: str


@dataclass(frozen=True)
class Section:
    """A section of a report. What it has is shown in the order of these attributes.

    Attributes:
        title: its heading; empty where what is above goes on.
        note: explanation of the section.
        head, rows: names of the columns and text of the cells of its table.
        picture: figure of the same numbers, shown above the table.
        bullets: a list of lines, above picture and table; commands: lines shown as typed there.
        level: level of the heading, from 1.
        text: whether all columns are text; else all but the first are numbers.
        folded: whether the table is shown on demand, under its title.
    """

    title: str = ""
    note: str = ""
    head: Row = ()
    rows: Sequence[Row] = ()
    picture: Picture | None = None
    bullets: Sequence[str] = ()
    commands: Sequence[str] = ()
    level: int = 2
    text: bool = False
    folded: bool = False


@dataclass(frozen=True, eq=False)
class Report:
    """The report of a study.

    Attributes:
        record: the results as table.json holds them.
        sections: sections of its page; figures are drawn and saved as they are taken.
    """

    record: Mapping[str, Any]
    sections: Iterator[Section]


def markdown(*sections: Section) -> str:
    """Sections in Markdown, as text that ends with a line feed; without pictures, and with every title of one level."""
    return "\n".join(line for section in sections for part in _parts(section) for line in (*part, "") if part)


def _parts(section: Section) -> Iterator[Sequence[str]]:
    """Lines of each part that a section may have."""
    yield [f"### {section.title}"] if section.title else []
    yield [section.note] if section.note else []
    yield [f"- {line}" for line in section.bullets]
    yield ["```", *section.commands, "```"] if section.commands else []
    rows = (section.head, ["---"] * len(section.head), *section.rows) if section.head else ()
    yield ["| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |" for cells in rows]


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


def as_text(value: Any) -> str:
    """A value of a parameter or a column as text; empty for None."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list | tuple):
        return " ".join(map(as_text, value))
    return "" if value is None else str(value)


def listed(values: Mapping[str, Any]) -> str:
    """Names and values as text, without those that are empty."""
    return ", ".join(f"{key}: {text}" for key, value in values.items() if (text := as_text(value)))
