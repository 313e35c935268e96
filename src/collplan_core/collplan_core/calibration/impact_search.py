"""The impacts in recorded poses, found as mocap_node finds them during a run.

The impacts published during the run serve less: mocap_node publishes one when it is certain, up to 80 ms late, and a
simulator's own list is the truth, which no laboratory has.
"""

from dataclasses import replace

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.sensing.pose_filter import FRESH, PoseSample, filter_pose


def find_impacts(times: np.ndarray, points: np.ndarray, settings: Settings) -> list[float]:
    """Times of the impacts in these poses [s]: times (n,) strictly rising [s], points (n, 2) [m].

    Uses what `filter_pose` does; `mocap.detect_impacts` counts as set.
    """
    watching = replace(settings, mocap=replace(settings.mocap, detect_impacts=True))
    memory, impacts = FRESH, []
    for time, point in zip(times.tolist(), points, strict=True):
        result, memory = filter_pose(memory, PoseSample(time, point, 0.0), time, watching)
        if result.impact is not None:
            impacts.append(result.impact.time)
    return impacts
