"""summary.json: the figures of a run."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from collplan_core.evaluation.path_length import measured_path_length, path_length
from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings, all_specs
from collplan_ros.run.impacts import Impacts
from collplan_ros.run.run_log import RunLog

CHOSEN = ("simulator.world", "simulator.seed")
"""Parameters of the simulator that are no assumptions about the robot."""


def summarize(log: RunLog, impacts: Impacts, outcome: str, goal: np.ndarray, settings: Settings) -> dict[str, Any]:
    """The figures of a run, ready for JSON.

    They cover the time from the first non-zero command to the end of the log; a run that reached its goal ends with the
    first pose within goal_tolerance. The rebound error is the median over the impacts that the last plan before each
    foresaw. Impacts and plans above limits.impact_speed are counted by the speed into the obstacle. Maneuvers are
    counted in control periods. The control period and the time of the first command come from the controller's
    middleware, which stamps its messages, so that the load of bringup does not affect them. Where simulated time waits
    for the nodes, the control period is one of simulated time.
    """
    begin, limit = log.time_zero, settings.limits.impact_speed
    commands = [c for c in log.commands if begin is not None and begin <= c.stamp]
    return {
        "outcome": outcome,
        "reached": outcome == REACHED,
        "arrival_time_s": log.arrival - begin if outcome == REACHED and begin is not None else None,
        "path_length_m": _length(log, begin),
        "path_length_source": "ground_truth" if log.truth else "mocap poses, low-passed at 5 Hz, resampled at 20 Hz",
        "impacts": len(impacts),
        "impacts_foreseen": int(impacts.verdicts.foreseen.sum()),
        "impacts_deliberate": int(impacts.verdicts.deliberate.sum()),
        "impacts_above_impact_speed": int((impacts.speeds > limit).sum()),
        "hardest_impact_m_s": float(impacts.speeds.max(initial=0.0)),
        "plans_above_impact_speed": sum(costs.get("hardest_contact", 0.0) > limit for costs in log.costs),
        "rebound_direction_error_deg": _median(np.degrees(impacts.direction_errors)),
        "goal": [float(value) for value in goal],
        "strategy": settings.planner.strategy,
        "plan_time_ms": _percentiles([costs["planning_time_ms"] for costs in log.costs if "planning_time_ms" in costs]),
        "control_period_ms": _percentiles(1e3 * np.diff([c.sent if log.pace else c.stamp for c in commands])),
        "candidates": {
            "mean": _mean(log, "candidates"),
            "before_pruning_mean": _mean(log, "candidates_before_pruning"),
        },
        "maneuvers": dict(Counter(c.maneuver for c in commands)),
    }


def assumed_constants(settings: Settings, simulated: bool) -> dict[str, Any]:
    """Values, by key, of all parameters documented as assumed, and of the simulator where the robot is simulated."""
    values = settings.values()

    def is_assumed(key: str, doc: str) -> bool:
        if key.startswith("simulator."):
            return simulated and key not in CHOSEN
        return "(assumed)" in doc

    return {key: values[key] for key, spec in all_specs().items() if is_assumed(key, spec.doc)}


def _length(log: RunLog, begin: float | None) -> float:
    if begin is None:
        return 0.0
    rows = np.array([row[:3] for row in log.track if begin <= row.stamp]).reshape(-1, 3)
    return path_length(rows[:, 1:]) if log.truth else measured_path_length(rows[:, 0], rows[:, 1:])


def _percentiles(values: Sequence[float] | np.ndarray) -> dict[str, Any]:
    if len(values) == 0:
        return {"p50": None, "p99": None, "n": 0}
    p50, p99 = np.percentile(values, [50, 99])
    return {"p50": float(p50), "p99": float(p99), "n": len(values)}


def _median(values: np.ndarray) -> float | None:
    """Median of the finite values; None where there are none."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else None


def _mean(log: RunLog, key: str) -> float | None:
    values = [costs[key] for costs in log.costs if key in costs]
    return float(np.mean(values)) if values else None


def counted_impacts(number: int) -> str:
    """Number of impacts in words: "1 impact", "2 impacts"."""
    return f"{number} impact{'' if number == 1 else 's'}"
