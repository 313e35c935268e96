"""Study of learning the drive: legs to and fro, with a robot that is not as it is believed to be.

    .venv/bin/python studies/learning.py --worlds 2 --setups doubled right
    .venv/bin/python studies/learning.py --worlds 24 --jobs 2
    .venv/bin/python studies/learning.py --worlds 6 --setups doubled --engine graph

Each run drives from the start to the goal and back, LEGS times, with learning off, on, or with the truth told. Planner
and controller believe the shipped parameters; the simulated robot is another. Rows are appended to runs/learning.jsonl
as they come; the next call goes on there, with the same code. Prints two tables: times, and what was learnt. Simulated.
"""

import argparse
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from itertools import groupby, product
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_core.learning.drive import DRIVE, Drive
from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_values
from collplan_core.worlds import World, load_world
from collplan_ros.bringup.driving import Bringup, wait_until_ready
from collplan_ros.bringup.options import parse
from collplan_study.question.question import parse_axes
from collplan_study.question.specification import SPREADS
from collplan_study.report.content import number
from collplan_study.run.pools import open_pool
from collplan_study.run.provenance import trial_code
from collplan_study.run.row_file import JsonLines
from markdown_text import Section, markdown
from omnipuck_sim.robot.physics import Simulator
from omnipuck_sim.trial import TrialJournals, TrialNodes, run_trial

LEGS, SETTLED = 6, 2
"""Legs of a run, and those after which the drive counts as learnt."""
FAMILIES = ("serpentine", "u")
FIRST_WORLD, FIRST_SEED, DRAW = 789100, 1000, 56
"""Worlds, noise and drawn robots; nothing was tuned on these."""
OFF, ON, TOLD = MODES = ("off", "on", "told")
SHIPPED = {key: value for key, (value,) in parse_axes(SPREADS).items()} | {"trial.timeout": 120.0}
RIGHT, DOUBLED = Drive(1.5, 0.1, 0.0), Drive(0.75, 0.2, 0.0)
"""The shipped belief, and the same robot of twice the mass."""
GRAPH = "graph"
"""In the place of an engine: pymunk, through the nodes, in one process."""


class Setup(NamedTuple):
    """A robot as it is: its drive, that in the middle legs where the floor changes, and other parameters."""

    drive: Drive
    middle: Drive | None = None
    values: Mapping[str, Any] = MappingProxyType({})


def drawn(count: int = 20) -> dict[str, Setup]:
    """Robots that nobody measured."""
    random, setups = np.random.default_rng(DRAW), {}
    for k in range(count):
        logs = random.uniform(np.log([0.5, 0.03]), np.log([4.0, 0.3]))
        setups[f"drawn {k}"] = Setup(Drive(*np.exp(logs).round(3).tolist(), round(random.uniform(0.0, 0.06), 3)))
    return setups


LOW_COST, NOISE = {"lidar.sensor": "low_cost"}, {"simulator.mocap_noise": 0.004}
LATE = 0.06
"""Delay of poses [s]."""
SETUPS = {
    "doubled": Setup(DOUBLED),
    "right": Setup(RIGHT),
    "a_max 0.75": Setup(RIGHT._replace(max_acceleration=0.75)),
    "a_max 1.0": Setup(RIGHT._replace(max_acceleration=1.0)),
    "a_max 2.0": Setup(RIGHT._replace(max_acceleration=2.0)),
    "lag 0.05": Setup(RIGHT._replace(lag=0.05)),
    "lag 0.25": Setup(RIGHT._replace(lag=0.25)),
    "floor": Setup(RIGHT, DOUBLED),
    "low_cost": Setup(DOUBLED, values=LOW_COST),
    "noise": Setup(DOUBLED, values=NOISE),
    "late": Setup(DOUBLED._replace(delay=LATE)),
    "right, low_cost": Setup(RIGHT, values=LOW_COST),
    "right, noise": Setup(RIGHT, values=NOISE),
    "right, late": Setup(RIGHT._replace(delay=LATE)),
    **drawn(),
}
SETUPS_IN_ORDER = list(SETUPS)


class Case(NamedTuple):
    """A run: the robot's name in SETUPS, the family and number of the world, the mode, and the engine or GRAPH."""

    setup: str
    family: str
    number: int
    mode: str
    engine: str

    @property
    def world(self) -> str:
        """The name of the world."""
        return f"{self.family}:{FIRST_WORLD + self.number}"

    def settings(self, drive: Drive) -> Settings:
        """Settings of a robot with this drive."""
        return Settings().with_values(
            {
                **SHIPPED,
                "planner.strategy": "bounce",
                "simulator.engine": self.engine,
                "simulator.mocap_latency": SETUPS[self.setup].drive.delay,
                "robot.max_acceleration": drive.max_acceleration,
                "robot.velocity_lag": drive.lag,
                "robot.motion_delay": drive.delay,
                **SETUPS[self.setup].values,
            }
        )


class Legs(TrialNodes):
    """A robot that drives to and fro."""

    case: Case

    def __init__(
        self, world: World, settings: Settings, seed: int, goal: np.ndarray, solid: World, journals: TrialJournals
    ) -> None:
        super().__init__(world, settings, seed, goal, solid, journals)
        setup = SETUPS[self.case.setup]
        self.simulator, self._other = (
            Simulator(solid, self.case.settings(drive), seed) for drive in (setup.drive, setup.middle or setup.drive)
        )
        self._changes = setup.middle is not None
        self._ends, self._given = (np.array(world.start), goal), 0.0
        self.legs: list[dict[str, Any]] = []  # for each leg its time [s], and what was learnt at its end
        runs.append(self)

    def step(self, steps: int) -> None:
        super().step(steps)
        if self._changes:
            self._other.step(round((self.simulator.time - self._other.time) * self.settings.simulator.physics_rate))

    def outcome(self) -> str | None:
        ended = super().outcome()
        if ended != REACHED:
            return ended
        now, drive = self.simulator.time, self.loop.controller.drive
        learnt = {} if drive.learnt is None else {"learnt": [each[:3] for each in drive.learnt]}
        self.legs.append({"time": now - self._given, **learnt, "in_use": drive.in_use})
        if len(self.legs) == LEGS:
            return REACHED
        if self._changes and len(self.legs) % 2 == 0:
            state, old = self.simulator.state, self.simulator
            self._other.place(state.position, state.velocity, state.yaw)
            self.simulator, self._other = self._other, old
        self._given = now
        self.loop.take_goal(self._ends[len(self.legs) % 2 == 0], now)
        return None

    @property
    def held(self) -> str:
        """Reason why the robot is held; "" where it is not."""
        return self.loop.controller.held


runs: list[Legs] = []
"""The newest run: `run_trial` makes the nodes itself."""


def row_of(case: Case) -> dict[str, Any]:
    """The row of a run."""
    return through_graph(case) if case.engine == GRAPH else through_trial(case)


def same_simulated_drive(max_acceleration: float, lag: float, settings: Settings) -> dict[str, float]:
    """The ratios with which a simulated robot drives as under these settings, once other constants are believed.

    From then on the believed ones are `max_acceleration` [m/s^2] and `lag` [s].
    """
    robot, simulation = settings.robot, settings.simulator
    true_lag = robot.velocity_lag * simulation.mass_ratio
    acceleration = robot.max_acceleration * simulation.acceleration_ratio / simulation.mass_ratio
    mass_ratio = true_lag / lag if lag > 0.0 else simulation.mass_ratio
    return {
        "simulator.mass_ratio": round(mass_ratio, 4),
        "simulator.acceleration_ratio": round(acceleration * mass_ratio / max_acceleration, 4),
    }


def through_graph(case: Case) -> dict[str, Any]:
    """The row of a run of bringup; a floor that changes cannot be simulated there."""
    setup = SETUPS[case.setup]
    believed = setup.drive if case.mode == TOLD else RIGHT
    true = case._replace(engine="pymunk").settings(setup.drive)
    ratios = same_simulated_drive(believed.max_acceleration, believed.lag, true)
    keys = ("robot.max_acceleration", "robot.velocity_lag", "robot.motion_delay")
    values = {**SHIPPED, **setup.values, "simulator.mocap_latency": setup.drive.delay, **ratios}
    values |= {**dict(zip(keys, believed, strict=True)), "robot.learning": DRIVE if case.mode == ON else OFF}
    with TemporaryDirectory() as folder:
        parameters, legs = Path(folder) / "robot.yaml", list[dict[str, Any]]()
        write_values(values, parameters)
        asked = ["--world", case.world, "--seed", str(FIRST_SEED + case.number), "--strategy", "bounce"]
        bringup = Bringup(parse([*asked, "--params", str(parameters), "--no-journal", "--out", f"{folder}/runs"]))
        with closing(bringup.folder), bringup:
            wait_until_ready(bringup)
            while len(legs) < LEGS:
                given = bringup.pose.stamp
                outcome = bringup.drive(bringup.preparation.ends[len(legs) % 2])
                if outcome != REACHED:
                    break
                legs.append({"time": bringup.pose.stamp - given})
            held = bringup.recorder.robot_held
            return {"case": case, "outcome": outcome, "reason": bringup.reason(outcome), "held": held, "legs": legs}


def through_trial(case: Case) -> dict[str, Any]:
    """The row of a run without ROS."""
    setup, index = SETUPS[case.setup], case.number
    believed = case.settings(setup.drive if case.mode == TOLD else RIGHT)
    learning = {"robot.learning": DRIVE if case.mode == ON else OFF}
    runs.clear()
    nodes = type("LegsOfCase", (Legs,), {"case": case})
    result = run_trial(load_world(case.world), believed.with_values(learning), FIRST_SEED + index, nodes_class=nodes)
    run = runs[0]
    return {"case": case, "outcome": result.outcome, "reason": result.reason, "held": run.held, "legs": run.legs}


def times(row: dict[str, Any]) -> list[float]:
    """The time of each leg; of legs that were not ended the longest allowed."""
    done = [leg["time"] for leg in row["legs"]]
    return done + [math.nan] * (LEGS - len(done))


def saving(rows: dict[str, dict[int, dict[str, Any]]], of: str, against: str) -> str:
    """Time from leg SETTLED on that one mode saves against another, over worlds where both ended [%]."""
    shares = []
    for k in rows[of].keys() & rows[against].keys():
        ours, theirs = (sum(times(rows[mode][k])[SETTLED:]) for mode in (of, against))
        if math.isfinite(ours + theirs):
            shares.append(100.0 * (1.0 - ours / theirs))
    if len(shares) < 2:
        return ", ".join(number(each, 1) for each in shares)
    return f"{np.mean(shares):.1f} +- {np.std(shares, ddof=1) / math.sqrt(len(shares)):.1f}"


def time_table(rows: Sequence[dict[str, Any]]) -> str:
    """Times and savings of each setup and family."""
    lines, key = [], lambda row: tuple(row["case"][:2])
    for (setup, family), group in groupby(sorted(rows, key=key), key):
        by_mode: dict[str, dict[int, dict[str, Any]]] = {mode: {} for mode in MODES}
        for row in group:
            by_mode[row["case"][3]][row["case"][2]] = row
        told = by_mode[TOLD] or by_mode[OFF]
        means = []
        for mode in (OFF, ON, TOLD):
            each = np.array([times(row) for row in by_mode[mode].values()]).reshape(-1, LEGS)
            ends = [np.nanmean(each[:, part]) if each[:, part].size else math.nan for part in (0, 1, slice(2, None))]
            unfinished = int(np.isnan(each).any(axis=1).sum())
            means.append(" / ".join(f"{end:.2f}" for end in ends) + (f" ({unfinished} not)" if unfinished else ""))
        compared = {**by_mode, TOLD: told}
        saved = [saving(compared, *pair) for pair in ((ON, OFF), (TOLD, OFF), (ON, TOLD))]
        lines.append((setup, family, str(len(by_mode[OFF])), *means, *saved))
    heads = ("robot", "worlds", "n", "off [s]", "on [s]", "told [s]")
    savings = ("on saves against off [%]", "told against off [%]", "on against told [%]")
    about = f"Mean times of legs 1 / 2 / from {SETTLED + 1} on; savings from leg {SETTLED + 1} on. Simulated."
    return markdown(Section("", about, (*heads, *savings), lines))


def learnt_table(rows: Sequence[dict[str, Any]]) -> str:
    """Errors of what was learnt after each leg, and the share that the intervals of nine in ten cover."""
    lines = []
    for kind, leg in product(("set-ups", "drawn"), range(LEGS)):
        errors = []
        for row in rows:
            setup = SETUPS[row["case"][0]]
            is_drawn, has_told = row["case"][0].startswith("drawn"), row["case"][3] == ON and row["case"][4] != GRAPH
            if not has_told or is_drawn != (kind == "drawn") or leg >= len(row["legs"]) or setup.middle:
                continue
            if "learnt" not in row["legs"][leg]:  # over before anything could be learnt
                continue
            found = zip(row["legs"][leg]["learnt"], setup.drive, (True, True, False), strict=True)
            errors.append([(math.log(m / t) if log else m - t, low <= t <= high) for (m, low, high), t, log in found])
        if not errors:
            continue
        each = np.array(errors, dtype=float)
        rms, worst, covered = np.sqrt((each[..., 0] ** 2).mean(0)), abs(each[..., 0]).max(0), each[..., 1].mean(0)
        scale = (100.0, 100.0, 1e3)
        told = (f"{s * r:.1f}, {s * w:.1f}; {c:.2f}" for s, r, w, c in zip(scale, rms, worst, covered, strict=True))
        lines.append((kind, str(leg + 1), str(len(errors)), *told))
    about = "Root mean square, worst; share covered. Of a_max and lag in per cent, of the delay in ms. Simulated."
    return markdown(Section("", about, ("robots", "after leg", "n", "a_max", "lag", "delay"), lines))


def cases(setups: Sequence[str], worlds: int, engine: str) -> Iterator[Case]:
    """The runs; a right belief is told already, and a drawn robot drives in one world of each family."""
    for name in setups:
        place = SETUPS_IN_ORDER.index(name)
        numbers = [place] if name.startswith("drawn") else range(worlds)
        for k, family, mode in product(numbers, FAMILIES, MODES):
            if mode != TOLD or SETUPS[name].drive != RIGHT:
                yield Case(name, family, k, mode, engine)


def main(args: Sequence[str] | None = None) -> int:
    """Runs what is not there yet, and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", type=int, default=2, help="worlds of each family (default 2)")
    parser.add_argument("--setups", nargs="+", choices=SETUPS_IN_ORDER, default=SETUPS_IN_ORDER, metavar="NAME")
    parser.add_argument("--engine", default="pymunk", help="pymunk, mujoco or graph (default pymunk)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    parser.add_argument("--out", type=Path, default=Path("runs/learning.jsonl"), help="the rows")
    given = parser.parse_args(args)
    out, code = JsonLines(given.out), trial_code()
    wanted = list(cases(given.setups, given.worlds, given.engine))
    there = {tuple(row["case"]) for row in out.records() if row["code"] == code}
    missing = [case for case in wanted if tuple(case) not in there]
    try:
        with open_pool(given.jobs, None) as (pool, jobs):
            for first in range(0, len(missing), jobs):
                # a pool of this process alone runs what it is given at once
                for future in [pool.submit(row_of, case) for case in missing[first : first + jobs]]:
                    out.append({**future.result(), "code": code})
                print(f"{min(first + jobs, len(missing))} of {len(missing)}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("stopped; the next call goes on here", file=sys.stderr)
        return 130
    rows = [row for row in out.records() if row["code"] == code and tuple(row["case"]) in set(wanted)]
    print(time_table(rows), learnt_table(rows), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
