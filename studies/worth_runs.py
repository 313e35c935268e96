"""The runs behind `make worth`: which robots, in which worlds, in which order.

The world is scaled with the radius about the origin, and so are the planner's lengths. The rebound spreads as in the
study of bounces.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.worlds import World, load_world
from collplan_study.question.bounces import SPREADS
from collplan_study.question.question import parse_axes
from omnipuck_sim.trial import run_trial

STRATEGIES = OURS, AGAINST = ("bounce", "avoid")
TURNING, BAFFLES = ("serpentine", "u"), ("baffles",)
SEEDS = range(8300, 8312)
"""Seeds of the worlds of each family, and of the noise in them; nothing was tuned on these."""
DRAWN_SEEDS = range(8312, 8318)
"""The same for the robots that are drawn."""
SHIPPED = Settings()
LENGTHS = (
    "planner.goal_tolerance",
    "remembered.spacing",
    "remembered.inferred_depth",
    "remembered.inferred_inset",
    "time_to_goal.half_side",
    "time_to_goal.grid_spacing",
    "time_to_goal.tolerant_distance",
    "time_to_goal.averse_distance",
)
"""Lengths of the planner that are chosen for a robot of the shipped radius."""
SPREAD = {key: value for key, (value,) in parse_axes(SPREADS).items()}


class Robot(NamedTuple):
    """A robot by N and restitution, and the engine that computes its contacts."""

    number: float
    restitution: float = 0.7
    radius: float = SHIPPED.robot.radius
    speed: float = SHIPPED.robot.max_speed
    engine: str = SHIPPED.simulator.engine

    @property
    def scale(self) -> float:
        return self.radius / SHIPPED.robot.radius

    def settings(self, strategy: str) -> Settings:
        shipped = SHIPPED.values()
        values = {key: self.scale * shipped[key] for key in LENGTHS} | {
            "robot.radius": self.radius,
            "robot.max_acceleration": self.speed**2 / (self.number * self.radius),
            **dict.fromkeys(("robot.max_speed", "cap.speed", "limits.impact_speed"), self.speed),
            **dict.fromkeys(("rebound.restitution", "simulator.restitution"), self.restitution),
            "simulator.engine": self.engine,
            "planner.strategy": strategy,
        }
        return SHIPPED.with_values({**SPREAD, **values})


class Run(NamedTuple):
    """A run: whose, where, how. The seed is that of the world and of the noise."""

    robot: Robot
    family: str
    seed: int
    strategy: str


CURVE_COMMIT = 0xC396DC16
"""Of the curve that the drawn robots test; as the seed of the draw it shows that they came later."""


def drawn(count: int = 6) -> Iterator[Robot]:
    """Robots to predict, with R, v_max, a_max and restitution drawn evenly, if their N is within the curve."""
    random = np.random.default_rng(CURVE_COMMIT)
    while count:
        radius, speed, acceleration, restitution = random.uniform(
            (0.09, 0.8, 0.5, 0.0), (0.225, 1.7, 4.0, 0.7)
        ).tolist()
        robot = Robot(speed**2 / (acceleration * radius), restitution, radius, speed)
        if 4.0 <= robot.number <= 16.0:
            count -= 1
            yield robot


FULL = [Robot(n) for n in (4.0, 6.0, 8.0, 11.0, 16.0, 24.0, 3.0)]
LOSSY = [Robot(n, e) for e in (0.2, 0.0, 0.4) for n in (16.0, 8.0, 4.0)]
LARGE = [Robot(n, 0.7, 0.225, 1.7) for n in (16.0, 8.0)]
MIDDLE = [Robot(n, e, 0.18) for n, e in ((16.0, 0.7), (8.0, 0.7), (16.0, 0.2))]
COMPLIANT = [Robot(n, e, engine="mujoco") for n, e in ((16.0, 0.7), (8.0, 0.7), (4.0, 0.7), (16.0, 0.2))]
DRAWN = list(drawn())
PARTS = (
    (FULL, TURNING, SEEDS),
    (LOSSY[:6], TURNING, SEEDS),
    (DRAWN, TURNING, DRAWN_SEEDS),
    (LARGE[:1], TURNING, SEEDS),
    (COMPLIANT[:1], TURNING, SEEDS),
    ([Robot(n) for n in (16.0, 8.0, 4.0)], BAFFLES, SEEDS),
    (LARGE[1:], TURNING, SEEDS),
    (COMPLIANT[1:], TURNING, SEEDS),
    (LOSSY[6:], TURNING, SEEDS),
    (MIDDLE, TURNING, SEEDS),
    ([Robot(n) for n in (24.0, 6.0, 11.0, 3.0)], BAFFLES, SEEDS),
)
"""Robots, families and seeds, what matters most first."""


def runs() -> Iterator[Run]:
    """All runs in their order; those compared follow one another."""
    for robots, families, seeds in PARTS:
        yield from (Run(*each) for each in product(robots, families, seeds, STRATEGIES))


def scaled(world: World, scale: float) -> World:
    """The world with every length multiplied, about the origin."""
    left, low, right, high = world.bounds
    return replace(
        world,
        polygons=tuple(scale * corners for corners in world.polygons),
        circles=scale * world.circles,
        bounds=(scale * left, scale * low, scale * right, scale * high),
        start=None if world.start is None else scale * world.start,
        goal=None if world.goal is None else scale * world.goal,
    )


def row_of(run: Run) -> dict[str, Any]:
    """The row of a run: how it ended, and when [s]."""
    world = scaled(load_world(f"{run.family}:{run.seed}"), run.robot.scale)
    result = run_trial(world, run.robot.settings(run.strategy), run.seed)
    return {**run._asdict(), "robot": run.robot._asdict(), "outcome": result.outcome, "time": result.arrival_time}


def run_of(row: dict[str, Any]) -> Run:
    return Run(Robot(**row["robot"]), row["family"], row["seed"], row["strategy"])
