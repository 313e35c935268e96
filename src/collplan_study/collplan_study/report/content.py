"""Content of a report: its figures, pictures, numbers as text, and the templates of its page."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from collplan_study.analysis.statistics import Estimate


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


@dataclass(frozen=True, eq=False)
class Report:
    """The report of a study.

    Attributes:
        record: the results as table.json holds them.
        template: template of its page, by name.
        values: values of that template.
    """

    record: Mapping[str, Any]
    template: str
    values: Mapping[str, Any]


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


@cache
def environment() -> Environment:
    """Environment of the templates; values are escaped."""
    made = Environment(
        loader=PackageLoader("collplan_study", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["base64"] = lambda text: base64.b64encode(text.encode()).decode()
    made.filters |= {"interval": with_interval, "number": number, "text": as_text, "listed": listed}
    return made
