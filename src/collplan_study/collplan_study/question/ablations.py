"""The named ablations: each changes one thing of the default parameters."""

from collections.abc import Mapping
from typing import Any

SHIPPED = "as shipped"
"""Name in reports of the cells without an ablation; in the tables their ablation is the empty string."""


def _restitution(value: float) -> dict[str, float]:
    """Restitution of the simulated robot and of the planner's rebound model alike."""
    return {"simulator.restitution": value, "rebound.restitution": value}


WITHOUT: dict[str, dict[str, Any]] = {
    "without R_ref": {"planner.rebound_reward": False},
    "without (1 - J_risk,h)": {"planner.collision_factor": False},
    "without position pruning": {"planner.position_pruning": False},
    "without velocity pruning": {"planner.velocity_pruning": False},
}
"""Ablations that leave out a part of the method."""

PRINTED: dict[str, dict[str, Any]] = {
    "J_pos as printed": {"planner.position_cost": "printed"},
    "angle of Alg. 1 as printed": {"planner.turn_angle": "printed"},
    "J_risk,g as printed": {"planner.gap_risk": "printed"},
    "no approach term, as printed": {"planner.approach_risk": "printed"},
    "shadow edges alone, as printed": {"planner.frontiers": "printed"},
    "speeds as printed": {"planner.speeds": "printed"},
    "time law as printed": {"planner.time_law": "printed"},
    "Alg. 3 as printed": {"controller.maneuver_rule": "printed"},
    "q_bound as printed": {"controller.boundary_projection": "printed"},
    "set E as printed": {"local_map.predicted": "printed"},
    "openings of any width, as printed": {"planner.widest_gap": 100.0},
    "frontiers of any length, as printed": {"planner.shortest_frontier": 0.0},
    "t_c of any length, as printed": {"planner.time_floor": 1e-9},
}
"""Ablations that put a reading of the paper back to its printed form."""

ALL_PRINTED = {key: value for changes in PRINTED.values() for key, value in changes.items()}
"""Every printed form at once."""

OTHERWISE: dict[str, dict[str, Any]] = {
    "goal vector as unit vector": {"planner.goal_vector": "unit"},
    "waypoints on the chord": {"planner.waypoints": "chord"},
    "first of equal costs": {"planner.tie_rule": "first"},
}
"""Ablations that make another choice where the paper leaves one open."""

ROBOT: dict[str, dict[str, Any]] = {
    "a_max 1 m/s^2": {"robot.max_acceleration": 1.0},
    "a_max 2 m/s^2": {"robot.max_acceleration": 2.0},
    "a_max 3 m/s^2": {"robot.max_acceleration": 3.0},
    "restitution 0.4": _restitution(0.4),
    "restitution 0.9": _restitution(0.9),
    "restitution 0.4, believed 0.7": {"simulator.restitution": 0.4},
    "restitution spread 0.2": {"simulator.restitution_spread": 0.2},
    "no noise": {"simulator.noise": 0.0},
    "noise doubled": {"simulator.noise": 2.0},
}
"""Ablations that set assumed constants of the robot; defaults: a_max 1.5 m/s^2, restitution 0.7, noise 1."""

ABLATIONS: Mapping[str, Mapping[str, Any]] = {
    "": {},
    **WITHOUT,
    **PRINTED,
    "all as printed": ALL_PRINTED,
    **OTHERWISE,
    **ROBOT,
}
"""Changed parameters of every ablation by name. The empty name comes first and changes nothing."""

DEFAULTS: Mapping[str, Any] = {"worlds": ("corridor", "random:0-19"), "map_periods": (0.2,), "trials": 5}
"""Parts of the question with `--ablations`, where the command line does not give them."""
