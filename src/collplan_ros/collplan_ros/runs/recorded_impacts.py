"""The hits of recorded runs, seen from the walls that were hit."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from collplan_core.calibration.impact_fit import FAR, ImpactFit, UnusableImpact, fit_impact
from collplan_core.calibration.impact_search import find_impacts
from collplan_core.calibration.wall_impacts import WallImpacts, seen_from_walls, sorted_out
from collplan_ros.runs.impact_log import nearest_surface
from collplan_ros.runs.recorded_run import RecordedRun

FARTHEST_WALL = 0.02
"""By which the robot's rim may miss the nearest surface at a hit, by noise and by a world measured by hand [m]."""


def measured_impacts(runs: Sequence[RecordedRun]) -> tuple[WallImpacts, Counter[str]]:
    """The usable hits of all runs, and how many others there were by reason.

    The normal is that of the world's surface nearest to the contact: the change of velocity has one only if the
    retention is known.
    """
    hits, normals, left_out = [], [], Counter[str]()
    for run in runs:
        times = find_impacts(run.path.times, run.path.points, run.settings)
        for time in times:
            try:
                hit, normal = _measured_impact(run, time, times)
            except UnusableImpact as error:
                left_out[str(error)] += 1
                continue
            hits.append(hit)
            normals.append(normal)
    usable, others = sorted_out(seen_from_walls(hits, np.array(normals)))
    return usable, left_out + others


def _measured_impact(run: RecordedRun, time: float, times: Sequence[float]) -> tuple[ImpactFit, np.ndarray]:
    if sum(abs(other - time) < FAR for other in times) > 1:
        raise UnusableImpact(f"another hit within {FAR:g} s")
    hit = fit_impact(run.path, time, run.settings.robot, run.settings.mocap.position_noise)
    point, normal = nearest_surface(run.world, hit.position)
    # a world without surfaces has its nearest one nowhere
    if not abs(np.linalg.norm(hit.position - point) - run.settings.robot.radius) <= FARTHEST_WALL:
        raise UnusableImpact("no surface of the world at the robot's rim")
    return hit, normal
