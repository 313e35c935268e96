"""What `bounce` saves against `avoid` by N = v_max^2 / (a_max R) and restitution, the curve behind `make worth`.

    make worth-study                       # runs what is missing, some 40 minutes on one core
    make worth-study ARGS="--no-run"       # the curve and the tables of the runs there are

The world is scaled with the radius about the origin, and so are the planner's lengths. The rebound spreads as in the
study of bounces. Rows are appended as they come, and one that is there is not run again. Simulated.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from collplan_core.parameters import Settings
from collplan_core.worlds import World, load_world
from collplan_study.question.bounces import SPREADS
from collplan_study.question.question import parse_axes
from collplan_study.run.row_file import JsonLines
from omnipuck_sim.trial import run_trial

STRATEGIES = OURS, AGAINST = ("bounce", "avoid")
TURNING, BAFFLES = ("serpentine", "u"), ("baffles",)
SEEDS = range(8300, 8312)
"""Of the worlds of each family, and of the noise in them; nothing was tuned on these."""
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


FULL = [Robot(n) for n in (4.0, 6.0, 8.0, 11.0, 16.0, 24.0, 3.0)]
LOSSY = [Robot(n, e) for n in (8.0, 16.0, 4.0, 24.0) for e in (0.2, 0.4, 0.0)]
LARGE = [Robot(n, 0.7, 0.225, 1.7) for n in (8.0, 16.0)]
COMPLIANT = [Robot(n, e, engine="mujoco") for n, e in ((16.0, 0.7), (8.0, 0.7), (4.0, 0.7), (16.0, 0.2))]
MIDDLE = [Robot(n, e, 0.18) for n, e in ((16.0, 0.7), (8.0, 0.7), (16.0, 0.2))]
PARTS = (
    (FULL, TURNING),
    (LOSSY[:6], TURNING),
    (LARGE, TURNING),
    (LOSSY[6:], TURNING),
    (FULL, BAFFLES),
    (COMPLIANT, TURNING),
    (MIDDLE, TURNING),
    (LOSSY[:6], BAFFLES),
    (LARGE, BAFFLES),
)
"""Robots and families, what matters most first."""


def runs() -> Iterator[Run]:
    """All runs in their order; those compared follow one another."""
    for robots, families in PARTS:
        yield from (Run(*each) for each in product(robots, families, SEEDS, STRATEGIES))


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


def main(args: Sequence[str] | None = None) -> int:
    """Runs what is not there yet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/worth.jsonl"), help="rows, one run a line")
    parser.add_argument("--no-run", action="store_true", help="run nothing")
    given = parser.parse_args(args)
    out = JsonLines(given.out)
    there = {run_of(row) for row in out.records()}
    missing = [] if given.no_run else [run for run in runs() if run not in there]
    for number_of, run in enumerate(missing, start=1):
        row = row_of(run)
        out.append(row)
        print(f"{number_of} of {len(missing)}: {run}: {row['outcome']}", file=sys.stderr, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
