"""The two questions that a study can ask: what tells one from the other, and the named changes of each."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL
from collplan_study.analysis.statistics import MEAN, SPREAD
from collplan_study.question.held_out import FAMILIES, FURTHER_FAMILIES, STUDY_SEED, TRIALS, held_out_worlds

Changes = Mapping[str, Mapping[str, Any]]
"""Changed parameters by name of the change. The empty name comes first and changes nothing."""

TIME, LENGTH = "arrival_time_s", "path_length_m"
PANELS = tuple((column, measure) for column in (TIME, LENGTH) for measure in (MEAN, SPREAD))
"""Column and statistic of each row of the paper's Table I, and of each panel of its figure over T_map."""
SAVED, SLOWER, LONGER = "saved", "slower", "longer"
"""Measures of pairs of runs: 100 (1 - ours / other) [%], share in which ours is slower [%], excess of ours [%]."""

PRINTED: Changes = {
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
"""Readings of the paper put back to their printed form."""
SPREAD_OF_HITS = "restitution spread 0.2"
ROBOT: Changes = {
    "a_max 1 m/s^2": {"robot.max_acceleration": 1.0},
    "a_max 2 m/s^2": {"robot.max_acceleration": 2.0},
    "a_max 3 m/s^2": {"robot.max_acceleration": 3.0},
    "restitution 0.4": {"simulator.restitution": 0.4, "rebound.restitution": 0.4},
    "restitution 0.9": {"simulator.restitution": 0.9, "rebound.restitution": 0.9},
    "restitution 0.4, believed 0.7": {"simulator.restitution": 0.4},
    SPREAD_OF_HITS: {"simulator.restitution_spread": 0.2},
    "no noise": {"simulator.noise": 0.0},
    "noise doubled": {"simulator.noise": 2.0},
}
"""Assumed constants of the robot; defaults: a_max 1.5 m/s^2, restitution 0.7, noise 1."""
ABLATIONS: Changes = {
    "": {},
    "without R_ref": {"planner.rebound_reward": False},
    "without (1 - J_risk,h)": {"planner.collision_factor": False},
    "without position pruning": {"planner.position_pruning": False},
    "without velocity pruning": {"planner.velocity_pruning": False},
    **PRINTED,
    "all as printed": {key: value for changes in PRINTED.values() for key, value in changes.items()},
    # where the paper leaves a choice open
    "goal vector as unit vector": {"planner.goal_vector": "unit"},
    "waypoints on the chord": {"planner.waypoints": "chord"},
    "first of equal costs": {"planner.tie_rule": "first"},
    **ROBOT,
}

KNOWN_MAP = "known map"
VARIANTS: Changes = {
    "": {},
    KNOWN_MAP: {"trial.known_map": True},
    # the main comparison of bounces has a spread already
    **{name: changes for name, changes in ROBOT.items() if name != SPREAD_OF_HITS},
    "restitution 0.7, believed 0.4": {"rebound.restitution": 0.4},
    # other bodies than the planner believes in; defaults: friction 0.12, massless wheels, 0.7 kg, lag 0.1 s
    "slippery ring, friction 0.03": {"simulator.friction": 0.03},
    "rough ring, friction 0.5": {"simulator.friction": 0.5},
    "wheels of 0.1 kg": {"simulator.wheel_mass": 0.1},
    "wheels of 0.35 kg": {"simulator.wheel_mass": 0.35},
    # with the same motors
    "mass doubled, not told": {"simulator.mass_ratio": 2.0},
    "mass doubled, told": {"robot.mass": 1.4, "robot.max_acceleration": 0.75, "robot.velocity_lag": 0.2},
    "a_max 20 % less than believed": {"simulator.acceleration_ratio": 0.8},
}
SPREADS = ("simulator.restitution_spread=0.08", "simulator.friction_spread=0.04")
"""--set values of the study of bounces: rebounds vary from impact to impact, so that no gain rests on rebounds that are
exactly foreseen."""
DEFAULTS: Mapping[str, Any] = {
    "worlds": tuple(map(held_out_worlds, (*FAMILIES, *FURTHER_FAMILIES))),
    "strategies": tuple(TIME_TO_GOAL),
    "trials": TRIALS,
    "seed": STUDY_SEED,
    "values": SPREADS,
    "ablations": True,
    "ablation_strategies": ("bounce", "avoid"),
    "ablation_trials": 1,
}


@dataclass(frozen=True, eq=False)
class Specification:
    """What tells one question from the other; grid, trials, tables and report are the same for both."""

    title: str
    defaults: Mapping[str, Any]
    """Parts of the question that the command line does not give."""
    with_ablations: Mapping[str, Any]
    """The same where ablations were asked for."""
    map_periods: Mapping[str, tuple[float, ...]]
    """T_map [s] of a strategy by its name; others are run at their own."""
    ablations: Changes
    reference: str
    against: str
    """The strategy that is judged, and that which it is compared with world by world; else the first that was run."""
    judged: tuple[tuple[str, str], ...]
    """Columns, and measures by which strategies are compared; the first tells what a change does, too."""
    losses: tuple[tuple[str, str], ...] = ()
    """Those that say what the strategy that is judged loses."""
    pooled: tuple[str, ...] = ()
    """Families that are also judged together."""


PAPER = Specification(
    title="Does harnessing collisions pay?",
    defaults={},
    with_ablations={"worlds": ("corridor", "random:0-19"), "map_periods": (0.2,), "trials": 5},
    map_periods=dict.fromkeys(PAPER_WEIGHTS, (0.2, 0.4, 0.6, 0.8, 1.0)),  # paper, IV-C
    ablations=ABLATIONS,
    reference="harness",
    against="high_risk",
    judged=PANELS,
)
BOUNCES = Specification(
    title="Do deliberate bounces pay?",
    defaults=DEFAULTS,
    with_ablations=DEFAULTS,
    map_periods={},
    ablations=VARIANTS,
    reference="bounce",
    against="avoid",
    judged=((TIME, SAVED),),
    losses=((TIME, SLOWER), (LENGTH, LONGER)),
    pooled=FAMILIES,
)
