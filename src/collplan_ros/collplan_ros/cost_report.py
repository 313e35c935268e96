"""planner/costs: what the choice of a cycle cost, for plotting."""

from diagnostic_msgs.msg import DiagnosticArray

from collplan_core.plan import Plan
from collplan_ros.conversions import stamp_from_seconds
from collplan_ros.diagnostics import OK, Health, status_message


def costs_message(name: str, plan: Plan, planning_time: float, strategy: str) -> DiagnosticArray:
    """Each term of the choice, counts before and after pruning, planning time; `planning_time` [s] is given in ms.

    Stamped with the plan's scan.
    """
    values: dict[str, object] = {
        "planning_time_ms": 1e3 * planning_time,
        "candidates": len(plan.candidates.costs),
        "candidates_before_pruning": plan.n_before_pruning,
        **plan.terms,
        "strategy": strategy,
    }
    message = DiagnosticArray(status=[status_message(name, Health(OK, "costs of the choice", values))])
    message.header.stamp = stamp_from_seconds(plan.stamp)
    return message
