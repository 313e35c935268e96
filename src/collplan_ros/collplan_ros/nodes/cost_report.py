"""The topic planner/costs: cost terms of the chosen candidate in each planning cycle, for plotting."""

from diagnostic_msgs.msg import DiagnosticArray

from collplan_core.plan import Plan
from collplan_ros.messages.conversions import stamp_from_seconds
from collplan_ros.node_kit.diagnostics import OK, Health, status_message


def costs_message(name: str, plan: Plan, planning_time: float, strategy: str) -> DiagnosticArray:
    """Message with each cost term of the chosen candidate, candidate counts before and after pruning, planning time.

    Args:
        name: full name of the publishing node.
        plan: the plan of the cycle; its stamp is the message's.
        planning_time: duration of the cycle [s], given in ms in the message.
        strategy: name of the planner's strategy.
    """
    values: dict[str, object] = {
        "planning_time_ms": 1e3 * planning_time,
        "candidates": len(plan.candidates.costs),
        "candidates_before_pruning": plan.n_before_pruning,
        "foreseen_contacts": len(plan.contacts.times),
        "hardest_contact": plan.contacts.hardest,
        **plan.terms,
        "strategy": strategy,
    }
    message = DiagnosticArray(status=[status_message(name, Health(OK, "costs of the choice", values))])
    message.header.stamp = stamp_from_seconds(plan.stamp)
    return message
