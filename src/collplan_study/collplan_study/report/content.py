"""Numbers of a report as text, and the environment of its template."""

import base64
from collections.abc import Mapping
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from collplan_study.analysis.statistics import Estimate


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
    """Environment of the template; values are escaped."""
    loader = PackageLoader("collplan_study", "templates")
    made = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    made.filters["base64"] = lambda text: base64.b64encode(text.encode()).decode()
    made.filters |= {"interval": with_interval, "number": number, "text": as_text, "listed": listed}
    return made
