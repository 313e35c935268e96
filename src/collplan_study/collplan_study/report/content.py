"""Numbers of a report as text."""

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
