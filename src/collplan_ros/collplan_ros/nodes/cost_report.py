"""The topic planner/costs: cost terms of the chosen candidate in each planning cycle, for plotting."""

import math
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticArray

from collplan_core.evaluation.rebound_tracking import MeasuredImpact
from collplan_core.plan import Plan
from collplan_ros.messages.conversions import stamp_from_seconds
from collplan_ros.node_kit.diagnostics import OK, Health, status_message


def costs_message(
    name: str, plan: Plan, planning_time: float, strategy: str, impact: MeasuredImpact | None = None
) -> DiagnosticArray:
    """Message with each cost term of the chosen candidate, candidate counts before and after pruning, planning time.

    Args:
        name: full name of the publishing node.
        plan: the plan of the cycle; its stamp is the message's.
        planning_time: duration of the cycle [s], given in ms in the message.
        strategy: name of the planner's strategy.
        impact: an impact measured since the previous message; None where there was none.
    """
    values: dict[str, object] = {
        "planning_time_ms": 1e3 * planning_time,
        "candidates": len(plan.candidates.costs),
        "candidates_before_pruning": plan.n_before_pruning,
        "foreseen_contacts": len(plan.contacts.times),
        "hardest_contact": plan.contacts.hardest,
        **plan.terms,
        "strategy": strategy,
        **({} if impact is None else _rebound_values(impact)),
    }
    message = DiagnosticArray(status=[status_message(name, Health(OK, "costs of the choice", values))])
    message.header.stamp = stamp_from_seconds(plan.stamp)
    return message


def _rebound_values(impact: MeasuredImpact) -> Mapping[str, object]:
    """Velocity after an impact, foreseen and measured; directions in the map frame [rad], NaN where not foreseen."""
    return {
        "rebound_stamp": f"{impact.stamp:.3f}",
        "rebound_foreseen_direction": math.atan2(impact.foreseen[1], impact.foreseen[0]),
        "rebound_foreseen_speed": math.hypot(*impact.foreseen),
        "rebound_measured_direction": math.atan2(impact.measured[1], impact.measured[0]),
        "rebound_measured_speed": math.hypot(*impact.measured),
        "rebound_direction_error_deg": math.degrees(impact.direction_error),
    }
