"""What `bounce` saves against `avoid` by N = v_max^2 / (a_max R) and restitution, the curve behind `make worth`.

    make worth-study                       # runs what is missing, some 40 minutes on one core
    make worth-study ARGS="--no-run"       # the curve and the tables of the runs there are

The world is scaled with the radius about the origin, and so are the planner's lengths. The rebound spreads as in the
study of bounces. Rows are appended as they come, and one that is there is not run again. Simulated.
"""

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.worlds import World, load_world
from collplan_study.analysis.statistics import MEAN, Estimate, level_of
from collplan_study.question.bounces import SPREADS
from collplan_study.question.question import parse_axes
from collplan_study.report.content import number, with_interval
from collplan_study.run.row_file import JsonLines
from markdown_text import Section, markdown
from omnipuck_sim.trial import run_trial
from worth_curve import CURVE, FAMILIES, Cell, expected, read_curve

STRATEGIES = OURS, AGAINST = ("bounce", "avoid")
TURNING, BAFFLES = ("serpentine", "u"), ("baffles",)
SEEDS = range(8300, 8312)
"""Of the worlds of each family, and of the noise in them; nothing was tuned on these."""
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


Saved = dict[Robot, dict[str, list[float]]]
"""Of each robot and family, the time that bounce saves in each world where both arrive [%]."""


def saved_by(rows: Sequence[dict[str, Any]]) -> Saved:
    """What the rows say."""
    times = {run_of(row): row["time"] for row in rows if row["outcome"] == REACHED}
    found: Saved = {}
    for run, time in times.items():
        against = times.get(run._replace(strategy=AGAINST))
        if run.strategy == OURS and against is not None:
            found.setdefault(run.robot, {}).setdefault(run.family, []).append(100.0 * (1.0 - time / against))
    return found


def mean_of(savings: Sequence[float]) -> Estimate:
    """The mean over worlds."""
    return level_of(MEAN, [np.array([each]) for each in savings])


def curve_of(saved: Saved) -> Iterator[Cell]:
    """Cells of the robots that differ from the shipped one in N and restitution alone, with all worlds."""
    for robot, families in saved.items():
        if robot == Robot(robot.number, robot.restitution):
            for family, each in families.items():
                mean = mean_of(each)
                if (
                    len(each) == len(SEEDS)
                    and mean.value is not None
                    and mean.low is not None
                    and mean.high is not None
                ):
                    yield Cell(family, robot.number, robot.restitution, mean.value, mean.low, mean.high)


def table(saved: Saved) -> Section:
    """A row a robot."""
    rows = []
    for robot in sorted(saved, key=lambda each: each[::-1]):
        families = saved[robot]
        together = [each for family in TURNING for each in families.get(family, [])]
        groups = (*(families.get(family, []) for family in FAMILIES), together)
        name = (f"{robot.radius:g}, {robot.speed:g}, {robot.engine}", f"{robot.restitution:g}", f"{robot.number:g}")
        rows.append((*name, *(f"{with_interval(mean_of(each), 1)} ({len(each)})" if each else "" for each in groups)))
    head = ("R [m], v_max [m/s], engine", "restitution", "N", *FAMILIES, "serpentine and u")
    note = "Mean and 95 % interval; in brackets the worlds in which both arrive."
    return Section("Time that bounce saves against avoid [%]", note, head, rows)


def predictions(saved: Saved) -> Section:
    """A row for each robot that was drawn after the curve: its prediction and what was measured."""
    cells, rows = read_curve(), []
    for robot in DRAWN:
        drawn_values = (robot.radius, robot.speed, robot.settings(OURS).robot.max_acceleration, robot.restitution)
        row = [number(each, 2) for each in drawn_values] + [number(robot.number, 1)]
        for family in TURNING:
            row.append(with_interval(expected(cells, family, robot.number, robot.restitution), 1))
            row.append(with_interval(mean_of(saved.get(robot, {}).get(family, [])), 1))
        rows.append(tuple(row))
    head = ("R [m]", "v_max [m/s]", "a_max [m/s^2]", "restitution", "N")
    told = tuple(f"{family}, {which}" for family in TURNING for which in ("predicted", "measured"))
    return Section("Robots drawn afterwards, time saved [%]", "", head + told, rows)


def main(args: Sequence[str] | None = None) -> int:
    """Runs what is not there yet, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/worth.jsonl"), help="rows, one run a line")
    parser.add_argument("--no-run", action="store_true", help="tables of the runs there are")
    parser.add_argument("--curve", action="store_true", help="write the curve that make worth reads")
    given = parser.parse_args(args)
    out = JsonLines(given.out)
    there = {run_of(row) for row in out.records()}
    missing = [] if given.no_run else [run for run in runs() if run not in there]
    for number_of, run in enumerate(missing, start=1):
        row = row_of(run)
        out.append(row)
        print(f"{number_of} of {len(missing)}: {run}: {row['outcome']}", file=sys.stderr, flush=True)
    rows = out.records()
    saved = saved_by(rows)
    if given.curve:
        CURVE.write_text("[\n" + ",\n".join(json.dumps(cell._asdict()) for cell in curve_of(saved)) + "\n]\n")
    measured = {robot: families for robot, families in saved.items() if robot not in DRAWN}
    print(markdown(table(measured), predictions(saved)))
    print(f"{len(rows)} runs, {sum(row['outcome'] == REACHED for row in rows)} arrived")
    return 0


if __name__ == "__main__":
    sys.exit(main())
