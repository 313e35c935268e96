"""The hits in recorded poses, found again as mocap_node found them while they came.

What was told of a hit during the run serves less: mocap_node tells of it when it is sure, up to 80 ms late, and a
simulator's own list is the truth, which no laboratory has.
"""

from dataclasses import replace

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.sensing.pose_filter import FRESH, PoseSample, filter_pose


def find_impacts(times: np.ndarray, points: np.ndarray, settings: Settings) -> list[float]:
    """When the hits in these poses were [s]: times (n,) strictly rising [s], points (n, 2) [m].

    Uses what `filter_pose` does; `mocap.detect_impacts` counts as set.
    """
    watching = replace(settings, mocap=replace(settings.mocap, detect_impacts=True))
    memory, hits = FRESH, []
    for time, point in zip(times.tolist(), points, strict=True):
        result, memory = filter_pose(memory, PoseSample(time, point, 0.0), time, watching)
        if result.impact is not None:
            # the track begins anew at the hit
            hits.append(float(memory.track.times[0]))
    return hits
