"""How often the 95 % intervals of fit_robot hold the truth, over simulated set-ups with all noise.

Each set-up is a robot with a restitution, friction, max_acceleration and lag of its own, drawn evenly, driven three
times 50 s into the walls of a small room. What its runs believe is the shipped default.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from time import process_time

import numpy as np

from bumping_drive import DrivenPose, bumping_drive
from collplan_core.calibration.fitted_constant import TooLittle, Unexplained
from collplan_core.calibration.impact_fit import RecordedPath
from collplan_core.calibration.wall_impacts import SLOWEST
from collplan_core.impact import Impact
from collplan_core.parameters import Settings
from collplan_core.plane import rotate_rows
from collplan_core.worlds import World
from collplan_ros.fit.fitting import RobotFit, fit_robot
from collplan_ros.fit.recorded_path import FittedRun
from omnipuck_sim.robot.physics import Simulator

RANGES = {
    "rebound.restitution": (0.4, 0.9),
    "rebound.friction": (0.03, 0.4),
    "robot.max_acceleration": (0.75, 3.0),
    "robot.velocity_lag": (0.05, 0.2),
}
"""What each constant is drawn from."""
TRUTH = {"rebound.restitution": "simulator.restitution", "rebound.friction": "simulator.friction"}
"""Where the simulator's own value has another name."""
RUNS, DURATION = 3, 50.0
"""Runs of a set-up, and how long each is [s]."""
ROOM = World(
    name="room",
    polygons=(),
    circles=np.zeros((0, 3)),
    bounds=(0.0, 0.0, 3.0, 0.9),
    walled=True,
    start=np.array([0.4, 0.4]),
    goal=None,
)
FIELD = World(
    name="field",
    polygons=(np.array([(0.0, -9.0), (1.0, -9.0), (1.0, 9.0), (0.0, 9.0)]),),
    circles=np.zeros((0, 3)),
    bounds=(-2.0, -9.0, 2.0, 9.0),
    walled=False,
    start=None,
    goal=None,
)
"""One long wall, for hits alone."""


def drawn_truth(setup: int) -> dict[str, float]:
    """The constants of set-up number `setup`."""
    random = np.random.default_rng([12, setup])
    return {key: float(random.uniform(*ends)) for key, ends in RANGES.items()}


def driven_runs(true: Settings, setup: int) -> list[list[DrivenPose]]:
    """The runs of a set-up by a robot with these settings."""
    return [list(bumping_drive(ROOM, true, 1000 * setup + i, DURATION)) for i in range(RUNS)]


def recorded(rows: Sequence[DrivenPose], true: Settings, believed: Settings, name: str) -> FittedRun:
    """A run as bringup records it."""
    yaws = np.array([row.measured.yaw for row in rows])
    times, points = (np.array([getattr(row.measured, name) for row in rows]) for name in ("stamp", "position"))
    path = RecordedPath(times, points, rotate_rows(np.array([row.command for row in rows]), yaws))
    return FittedRun(name, True, believed, ROOM, path, np.unwrap(yaws))


def true_restitution(impacts: Sequence[Impact], true: Settings) -> float:
    """The restitution that the ring has in these hits, each repeated alone, without drive and spin.

    By pymunk it is simulator.restitution; by MuJoCo it depends on the angle (docs/limits.md).
    """
    into, out = [], []
    for impact in impacts:
        speed, along = (
            -(impact.velocity_before @ impact.normal),
            impact.velocity_before @ np.array([-impact.normal[1], impact.normal[0]]),
        )
        if speed > SLOWEST:
            robot = Simulator(FIELD, true, 0, start=np.array([-0.5, 0.0]))
            robot.place(np.array([-true.robot.radius - 0.01, 0.0]), np.array([speed, along]))
            robot.drive = False
            for _ in range(round((0.01 / speed + 2.0 * true.simulator.contact_time) * true.simulator.physics_rate)):
                robot.step()
            into.append(speed)
            out.append(-robot.state.velocity[0])
    return float(np.dot(into, out) / np.dot(into, into))


def fitted(setup: int, engine: str) -> tuple[dict[str, float], RobotFit | str]:
    """The true constants of a set-up, and their fit, or why there is none."""
    truth, believed = drawn_truth(setup), Settings().with_values({"simulator.engine": engine})
    true = believed.with_values({TRUTH.get(key, key): value for key, value in truth.items()})
    runs = driven_runs(true, setup)
    impacts = [impact for rows in runs for row in rows for impact in row.impacts]
    truth["rebound.restitution"] = true_restitution(impacts, true)
    try:
        names = (f"run {1000 * setup + i}" for i in range(RUNS))
        return truth, fit_robot([recorded(rows, true, believed, name) for rows, name in zip(runs, names, strict=True)])
    except (TooLittle, Unexplained) as error:
        return truth, str(error).splitlines()[0]


def main(args: Sequence[str] | None = None) -> None:
    """Fits all set-ups and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--setups", type=int, default=200, help="number of set-ups (%(default)s)")
    parser.add_argument("--first", type=int, default=0, help="number of the first one (%(default)s)")
    parser.add_argument("--engine", default="pymunk", help="simulator.engine (%(default)s)")
    parser.add_argument("--verbose", action="store_true", help="print every set-up")
    options = parser.parse_args(args)
    begun, errors, held, refusals = process_time(), {key: [] for key in RANGES}, Counter(), []
    for setup in range(options.first, options.first + options.setups):
        truth, fit = fitted(setup, options.engine)
        if isinstance(fit, str):
            refusals.append(f"set-up {setup}: {fit}")
            continue
        for key, constant in fit.constants.items():
            held[key] += constant.holds(truth[key])
            errors[key].append((constant.value - truth[key], constant.high - constant.low))
            if options.verbose:
                found = f"{constant.value:.4f} [{constant.low:.4f}, {constant.high:.4f}]"
                print(setup, key, f"{truth[key]:.4f}", found, constant.holds(truth[key]), flush=True)
    fits = options.setups - len(refusals)
    print(f"simulated, engine {options.engine}: {options.setups} set-ups, {len(refusals)} refused")
    print(f"{'':<24}intervals that hold the truth   mean error   mean width of the interval")
    for key in RANGES:
        error, width = np.mean(np.reshape(errors[key], (-1, 2)), axis=0) if fits else (np.nan, np.nan)
        share = 100.0 * held[key] / max(fits, 1)
        print(f"{key:<24}{held[key]:4} of {fits:4}   {share:5.1f} %         {error:+.4f}      {width:.4f}")
    print("\n".join(refusals))
    print(f"{(process_time() - begun) / options.setups:.1f} s of computing a set-up")


if __name__ == "__main__":
    sys.exit(main())
