"""planner/costs: what the choice of a cycle cost, for plotting."""

import math
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticArray

from collplan_core.evaluation.rebound_tracking import MeasuredImpact
from collplan_core.plan import Plan
from collplan_ros.messages.conversions import stamp_from_seconds
from collplan_ros.node_kit.diagnostics import OK, Health, status_message


def costs_message(
    name: str, plan: Plan, planning_time: float, strategy: str, hit: MeasuredImpact | None = None
) -> DiagnosticArray:
    """Each term of the choice, counts before and after pruning, planning time; `planning_time` [s] is given in ms.

    Stamped with the plan's stamp. A `hit` is given in the first message after it was measured.
    """
    values: dict[str, object] = {
        "planning_time_ms": 1e3 * planning_time,
        "candidates": len(plan.candidates.costs),
        "candidates_before_pruning": plan.n_before_pruning,
        "foreseen_contacts": len(plan.contacts.times),
        **plan.terms,
        "strategy": strategy,
        **({} if hit is None else _rebound_values(hit)),
    }
    message = DiagnosticArray(status=[status_message(name, Health(OK, "costs of the choice", values))])
    message.header.stamp = stamp_from_seconds(plan.stamp)
    return message


def _rebound_values(hit: MeasuredImpact) -> Mapping[str, object]:
    """Foreseen against measured, directions in the map frame [rad]; NaN where it was not foreseen."""
    return {
        "rebound_stamp": f"{hit.stamp:.3f}",
        "rebound_foreseen_direction": math.atan2(hit.foreseen[1], hit.foreseen[0]),
        "rebound_foreseen_speed": math.hypot(*hit.foreseen),
        "rebound_measured_direction": math.atan2(hit.measured[1], hit.measured[0]),
        "rebound_measured_speed": math.hypot(*hit.measured),
        "rebound_direction_error_deg": math.degrees(hit.direction_error),
    }
