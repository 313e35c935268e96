"""Odometry and a localisation in place of motion capture, simulated: what an odometry that slips in hits costs.

The odometry counts the way 1 % too long, and of the change of velocity in a hit it does not see a share at first. A
localisation ties it to the map five times a second, within 5 mm. Both go the way of mocap_node with mocap.localised.

    python studies/slipping_odometry.py [--worlds 24]
"""

import argparse
import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from multiprocessing import Pool
from typing import Any

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.sensing.localised import FrameInMap
from collplan_core.sensing.pose_filter import FilterResult, PoseSample
from collplan_core.worlds import load_world
from collplan_ros.nodes.mocap_node import in_map
from omnipuck_sim.trial import TrialNodes, run_trial

FIRST = 531000
"""Seed of the first world, which is that of its trial too."""
SLIPS, SLIP_TIMES = (0.1, 0.2, 0.3), (0.0, 0.05, 0.1)
"""Shares of the change of velocity that the odometry does not see, and values of mocap.slip_time [s]."""
FADES = 0.05
"""Time constant of what it does not see [s]."""
SCALE, NOISE = 1.01, 2e-4
CORRECTION, ERROR = 0.2, 0.005
"""Period of the localisation [s], and standard deviation of its places by axis [m]."""
HIT = 0.1
"""Change of velocity between two poses, 10 ms apart, that no drive makes [m/s]."""


class OdometryNodes(TrialNodes):
    """Nodes of a robot whose poses come from an odometry."""

    slip = 0.2

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self._random, true = np.random.default_rng(given[2]), self.simulator.state
        self._before, self._unseen, self._counted = true, np.zeros(2), np.zeros(2)
        self._frame, self._tied, self._slips_until = FrameInMap(0.0, 0.0, 0.0), -math.inf, -math.inf

    def measure(self) -> None:
        true, before = self.simulator.state, self._before
        change = true.velocity - before.velocity
        self._unseen *= math.exp(-(true.stamp - before.stamp) / FADES)
        if np.hypot(*change) > HIT:
            self._unseen += self.slip * change
        way = true.position - before.position - self._unseen * (true.stamp - before.stamp)
        self._before, self._counted = true, self._counted + SCALE * way
        if true.stamp >= self._tied + CORRECTION:
            drift = true.position + self._random.normal(0.0, ERROR, 2) - self._counted
            self._frame, self._tied = FrameInMap(float(drift[0]), float(drift[1]), 0.0), true.stamp
        position = self._counted + self._random.normal(0.0, NOISE, 2)
        self.measured.append(replace(self.simulator.measured_pose(), position=position, yaw=true.yaw))

    def filtered(self, sample: PoseSample) -> FilterResult:
        result = super().filtered(sample)
        if result.impact is not None:
            self._slips_until = sample.stamp + self.settings.mocap.slip_time
        result = in_map(result, self._frame)
        return replace(result, state=None) if sample.stamp < self._slips_until else result


def time_of(strategy: str, slip: float | None, slip_time: float, seed: int) -> float:
    """Time to the goal of a trial [s], NaN where it does not arrive; `slip` None is motion capture."""
    values = {"planner.strategy": strategy, "mocap.slip_time": slip_time}
    nodes = TrialNodes if slip is None else type("Slipping", (OdometryNodes,), {"slip": slip})
    result = run_trial(load_world(f"serpentine:{seed}"), Settings().with_values(values), seed, nodes_class=nodes)
    return result.arrival_time if result.outcome == REACHED else math.nan


def rows(worlds: int) -> Iterator[str]:
    """The lines of a Markdown table."""
    seeds = range(FIRST, FIRST + worlds)
    yield "| strategy | slip | mocap.slip_time | arrived | mean time s | against motion capture |"
    yield "|---|---|---|---|---|---|"
    with Pool(2) as pool:
        for strategy in ("bounce", "avoid"):
            by_mocap = np.array(pool.map(partial(time_of, strategy, None, 0.0), seeds, chunksize=1))
            yield f"| {strategy} | motion capture | | {np.isfinite(by_mocap).sum()} | {np.nanmean(by_mocap):.3f} | |"
            for slip in SLIPS:
                for slip_time in SLIP_TIMES:
                    times = np.array(pool.map(partial(time_of, strategy, slip, slip_time), seeds, chunksize=1))
                    change = 100.0 * (times / by_mocap - 1.0)
                    change = change[np.isfinite(change)]
                    error = change.std(ddof=1) / math.sqrt(len(change))
                    against = f"{change.mean():+.1f} +- {error:.1f} %"
                    arrived = int(np.isfinite(times).sum())
                    yield f"| {strategy} | {slip:g} | {slip_time:g} | {arrived} | {np.nanmean(times):.3f} | {against} |"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="What an odometry that slips in hits costs; simulated.")
    parser.add_argument("--worlds", type=int, default=24)
    for line in rows(parser.parse_args().worlds):
        print(line, flush=True)
