"""The question of `--bounces`, what deliberate bounces gain, and its variants, which change one thing each."""

from collections.abc import Mapping
from typing import Any

from collplan_core.strategies import TIME_TO_GOAL
from collplan_study.question.ablations import ROBOT
from collplan_study.question.held_out import FAMILIES, FURTHER_FAMILIES, STUDY_SEED, TRIALS, held_out_worlds

KNOWN_MAP = "known map"

SPREADS = ("simulator.restitution_spread=0.08", "simulator.direction_spread=0.06")
"""--set values of the main comparison: simulated rebounds vary from impact to impact, so that no gain rests
on rebounds that are exactly foreseen."""

ROBOTS = (
    "a_max 1 m/s^2",
    "a_max 2 m/s^2",
    "a_max 3 m/s^2",
    "restitution 0.4",
    "restitution 0.9",
    "no noise",
    "noise doubled",
)
"""Names of the ablations of the robot that are variants here too."""

VARIANTS: Mapping[str, Mapping[str, Any]] = {
    "": {},
    KNOWN_MAP: {"trial.known_map": True},
    **{name: ROBOT[name] for name in ROBOTS},
    "restitution 0.7, believed 0.4": {"rebound.restitution": 0.4},
}
"""Changed parameters of each variant by name. The empty name is the main comparison and changes nothing."""

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
"""Parts of the question with `--bounces`, where the command line does not give them."""
