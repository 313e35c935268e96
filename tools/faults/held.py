"""Faults after which the robot must be held, in trials: turned motion, failing plans, a carried robot."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from lying_scans import Watched, watched_trial

from collplan_core.control.permission import plan_lifetime
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of
from collplan_core.sensing.pose_filter import PoseSample
from faults.bench import Bench
from faults.fault import Fault, Measured
from faults.trials import STRATEGY, room, seed_of, world
from omnipuck_sim.robot.noise import faulty
from omnipuck_sim.robot.physics import Simulator
from omnipuck_sim.trial import run_trial

SETTINGS = Settings().with_values({"planner.strategy": STRATEGY})
TURNED = 0.3
"""Longest way of a robot that moves against its commands [m]."""
NO_PLANS = plan_lifetime(map_period_of(SETTINGS.planner))
"""Longest time from the first cycle without a plan to zero [s]."""
CARRIED = 0.15
"""Longest time from the first pose off the floor, or elsewhere, to zero [s]."""
AT = 1.0, 1.6
"""When plans begin to fail, or somebody takes the robot [s]."""
LASTS = 1.5
"""For so long plans fail [s]: after over a second the robot is held."""
WATCHED = 3.0
"""Time watched from then on [s]."""


def turned(bench: Bench, seed: int) -> Measured:
    """Its wheels drive the robot at an angle drawn by the seed to where they should, from its start on."""
    angle = np.random.default_rng([14, seed]).uniform(0.5 * math.pi, 1.5 * math.pi)
    c, s = math.cos(angle), math.sin(angle)
    command = Simulator.command

    def commanded(simulator: Simulator, velocity: np.ndarray, yaw_rate: float) -> None:
        command(simulator, np.array([[c, -s], [s, c]]) @ np.asarray(velocity), yaw_rate)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Simulator, "command", commanded)
        result = run_trial(room({}), SETTINGS.with_values({"trial.timeout": WATCHED}), seed)
    way, speed = result.path_length, float(np.hypot(*result.trajectory[:, 3:].T).max())
    return Measured(missed=f"{way:.2f} m, limit {TURNED:g} m" if way > TURNED else "", speed=speed, distance=way)


def without_plans(bench: Bench, seed: int) -> Measured:
    """The planner goes on and fails to plan, and plans again when it is too late for the robot to go on by itself."""
    at = np.random.default_rng([15, seed]).uniform(*AT)
    plan, failed = PlannerLoop._plan, []

    def fails(loop: PlannerLoop, initial, valid_until: float, local: float, deadline) -> None:
        if not at <= local < at + LASTS:
            return plan(loop, initial, valid_until, local, deadline)
        failed.append(local)
        return loop._report_no_plan("no_plan", "made to fail", local)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(PlannerLoop, "_plan", fails)
        seen = watched(seed, at + WATCHED)
    return stood(seen, failed[0] if failed else at)


def carried(shortest: float, longest: float) -> Callable[[Bench, int], Measured]:
    """Somebody lifts the robot while it drives and puts it down where it started, after a time between these [s]."""

    def measure(bench: Bench, seed: int) -> Measured:
        chance = np.random.default_rng([16, seed])
        at, lasts = chance.uniform(*AT), chance.uniform(shortest, longest)
        measured, put = Simulator.measured_pose, []

        def lifted(simulator: Simulator) -> PoseSample:
            down = simulator.time >= at + lasts
            if down and not put:
                put.append(simulator.time)
                simulator.reset()
            return faulty(measured(simulator), "lift" if at <= simulator.time and not down else "none")

        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(Simulator, "measured_pose", lifted)
            return stood(watched(seed, at + lasts + WATCHED), at)

    return measure


def watched(seed: int, seconds: float) -> Watched:
    return watched_trial(None, world(seed), STRATEGY, seed, **{"trial.timeout": seconds})


def stood(seen: Watched, at: float) -> Measured:
    """The time from `at` [s] to the zero that only zeros follow; a miss where it is not held in the end."""
    moving = [time for time, is_zero, _ in seen.commands if not is_zero]
    if not any(at - 0.1 < time <= at for time in moving):
        return Measured(unbegun="it stood already")
    stands = next((time for time, _, _ in seen.commands if time > moving[-1]), None)
    reason = seen.commands[-1][2]
    missed = "" if reason.startswith("held") else f"it is not held: {reason or 'it drives on'}"
    return Measured(None if stands is None else stands - at, missed)


def row(name: str, limit: float | None, measure: Callable[[Bench, int], Measured]) -> Fault:
    return Fault(name, "trial", limit, seed_of, measure)


FAULTS = [
    row("motion turned by 90 to 270 degrees, in free space: 0.3 m at most", None, turned),
    row("no plans from a running planner for 1.5 s, then no motion", NO_PLANS, without_plans),
    row("robot lifted, put down at its start after over 1 s: held", CARRIED, carried(1.1, 2.5)),
    row("robot moved to its start from one pose to the next: held", CARRIED, carried(0.0, 0.0)),
]
