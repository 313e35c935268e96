"""Report of a replay."""

from collections.abc import Iterable, Iterator, Sequence

from collplan_core.replay.comparison import Comparison, Difference, Interruption
from collplan_core.replay.journal import PLANNER, changes
from collplan_core.replay.other_strategy import Moment, PlanFigures

SAME, DIFFERENT, REFUSED, INTERRUPTED = 0, 1, 2, 3
"""Exit codes: bit-equal, a difference, a request that cannot be fulfilled, and equal up to a gap."""


def said_of(of: str, comparison: Comparison) -> Iterator[str]:
    """Yields the report's lines on a loop."""
    plans = f"{comparison.plans} plan{'' if comparison.plans == 1 else 's'}"
    commands = f"{comparison.commands} command{'' if comparison.commands == 1 else 's'}"
    done = f"{of}: {plans if of == PLANNER else commands} bit-equal, from {comparison.calls} inputs"
    yield done if comparison.end is None else f"{done}; then {comparison.end}"
    if isinstance(comparison.end, Difference) and comparison.beginning is not None:
        for change in changes(comparison.beginning.made_with):
            yield f"  {change}"


def exit_code(comparisons: Iterable[Comparison]) -> int:
    """Returns the exit code of the result; a difference has priority over a gap."""
    ends = [comparison.end for comparison in comparisons]
    if any(isinstance(end, Difference) for end in ends):
        return DIFFERENT
    return INTERRUPTED if any(isinstance(end, Interruption) for end in ends) else SAME


def table_of(moments: Sequence[Moment], own: str, other: str) -> Iterator[str]:
    """The plans of two strategies moment by moment, a line each; time counts from the first."""
    figures = "ends   length  left    contact"
    yield f"{'':8}{own:<33}{other}"
    yield f"t [s]   {figures}  {figures}"
    for moment in moments:
        line = f"{moment.stamp - moments[0].stamp:<8.3f}{_row(moment.own)}  {_row(moment.other)}"
        yield f"{line}  {moment.note}".rstrip()


def _row(plan: PlanFigures | None) -> str:
    if plan is None:
        return f"{'-':<31}"
    contact = "-" if plan.first_contact is None else f"{plan.first_contact:.3f}"
    return f"{plan.duration:<7.3f}{plan.length:<8.3f}{plan.left:<8.3f}{contact:<8}"
