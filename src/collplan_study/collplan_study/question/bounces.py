"""The question of `--bounces`, the gain by deliberate bounces, and its variants, which change one thing each."""

from collections.abc import Mapping
from typing import Any

from collplan_core.strategies import TIME_TO_GOAL
from collplan_study.question.ablations import ROBOT
from collplan_study.question.held_out import FAMILIES, FURTHER_FAMILIES, STUDY_SEED, TRIALS, held_out_worlds
from omnipuck_sim.robot.engine import MUJOCO

KNOWN_MAP = "known map"

SPREADS = ("simulator.restitution_spread=0.08", "simulator.friction_spread=0.04")
"""--set values of the main comparison: simulated rebounds vary from impact to impact, so that no gain rests
on rebounds that are exactly foreseen."""

ROBOTS = (
    "a_max 1 m/s^2",
    "a_max 2 m/s^2",
    "a_max 3 m/s^2",
    "restitution 0.4",
    "restitution 0.9",
    "restitution 0.4, believed 0.7",
    "no noise",
    "noise doubled",
)
"""Names of the ablations of the robot that are variants here too."""

BODY: Mapping[str, Mapping[str, Any]] = {
    "slippery ring, friction 0.03": {"simulator.friction": 0.03},
    "rough ring, friction 0.5": {"simulator.friction": 0.5},
    "wheels of 0.1 kg": {"simulator.wheel_mass": 0.1},
    "wheels of 0.35 kg": {"simulator.wheel_mass": 0.35},
    "mass doubled, not told": {"simulator.mass_ratio": 2.0},
    "mass doubled, told": {"robot.mass": 1.4, "robot.max_acceleration": 0.75, "robot.velocity_lag": 0.2},
    "a_max 20 % less than believed": {"simulator.acceleration_ratio": 0.8},
}
"""Other bodies than the planner believes in. Defaults: friction 0.12, massless wheels, 0.7 kg, a_max 1.5 m/s^2, lag
0.1 s. The mass is doubled with the same motors; "told" sets the planner's mass, acceleration and lag too."""

COMPLIANT: Mapping[str, Mapping[str, Any]] = {"soft ring, 40 ms": {"simulator.contact_time": 0.04}}
"""Changes that only the engine with a compliant ring knows; its default is 15 ms."""

VARIANTS: Mapping[str, Mapping[str, Any]] = {
    "": {},
    KNOWN_MAP: {"trial.known_map": True},
    **{name: ROBOT[name] for name in ROBOTS},
    "restitution 0.7, believed 0.4": {"rebound.restitution": 0.4},
    **BODY,
}
"""Changed parameters of each variant by name. The empty name is the main comparison and changes nothing."""


def variants_of(engine: str) -> Mapping[str, Mapping[str, Any]]:
    """The variants that an engine can show."""
    return {**VARIANTS, **COMPLIANT} if engine == MUJOCO else VARIANTS


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
