"""Scans that lie, and a robot that is carried: trials, whose clock no machine stalls."""

from collections.abc import Callable
from functools import partial

import numpy as np
from lying_scans import LIES, lying_trial, world
from watched_trials import FalsePoses, watched_trial

from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of
from collplan_core.worlds import load_world
from faults.runner import Fault, Measured
from omnipuck_sim.robot.noise import faulty

STRATEGY = "avoid"
SCAN = map_period_of(Settings().with_values({"planner.strategy": STRATEGY}).planner) + 0.2
"""Longest time from the first scan that lies to the robot's standing [s]."""
CARRIED = 0.15
"""Longest time from the first pose off the floor, or elsewhere, to zero [s]."""
AT, WATCHED = (1.0, 1.6), 3.0
"""When somebody takes the robot, and the time watched once it is down again [s]."""
SCANS = {
    "nothing near": "every beam +Inf",
    "half empty": "half of the beams +Inf",
    "frozen": "frozen to the last bit",
    "lost": "60 % of the beams NaN",
    "late 0.3 s unnoticed": "0.3 s old, stamped as new",
    "late 0.5 s": "0.5 s late by their stamps",
}


def lying(name: str, seed: int) -> Measured:
    watched = lying_trial(LIES[name], world(seed), STRATEGY, seed, trial__stuck_time=1.0)
    if not np.isfinite(watched.begun):
        return Measured(unbegun=f"seed {seed} never drove fast enough")
    return Measured(float(watched.stood) if np.isfinite(watched.stood) else None)


class Carried(FalsePoses):
    """Somebody lifts the robot, and puts it down where it started when that is over."""

    is_down = False

    def measure(self) -> None:
        if not self.is_down and self.simulator.time >= self.at + self.lasts:
            self.is_down = True
            self.simulator.reset()
        super().measure()


def carried(shortest: float, longest: float, seed: int) -> Measured:
    """It is lifted while it drives, for a time between these [s]; the time until zero that only zeros follow."""
    chance = np.random.default_rng([16, seed])
    at, lasts = chance.uniform(*AT), chance.uniform(shortest, longest)
    nodes, timeout = partial(Carried, partial(faulty, fault="lift"), at, lasts), at + lasts + WATCHED
    watched = watched_trial(load_world(world(seed)), STRATEGY, seed, nodes, trial__timeout=timeout)
    if not any(row.speed and at - 0.1 < row.time <= at for row in watched.said):
        return Measured(unbegun="it stood already")
    stands = next((row.time for row in watched.said if row.time > watched.last_moving_command), None)
    reason = watched.said[-1].reason
    missed = "" if reason.startswith("held") else f"it is not held: {reason or 'it drives on'}"
    return Measured(None if stands is None else stands - at, missed)


def row(name: str, limit: float, measured: Callable[[int], Measured], long: int = 100) -> Fault:
    """A row whose cases have seeds of their own, from 0 on."""
    return Fault(name, "trial", limit, lambda bench: bench.number, lambda bench, seed: measured(seed), long=long)


FAULTS = [
    *(row(f"scan: {words}", SCAN, partial(lying, name), 30) for name, words in SCANS.items()),
    row("robot lifted, put down at its start after over 1 s: held", CARRIED, partial(carried, 1.1, 2.5)),
    row("robot moved to its start from one pose to the next: held", CARRIED, partial(carried, 0.0, 0.0)),
]
