"""The impacts of recorded runs, in the frames of the walls."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from collplan_core.calibration.impact_fit import FAR, ImpactFit, UnusableImpact, fit_impact
from collplan_core.calibration.impact_search import find_impacts
from collplan_core.calibration.wall_impacts import WallImpacts, seen_from_walls, sorted_out
from collplan_ros.runs.impact_log import nearest_surface
from collplan_ros.runs.recorded_run import RecordedRun

FARTHEST_WALL = 0.02
"""Largest distance between the robot's rim and the nearest surface at an impact [m]: noise, and errors of the world."""


def measured_impacts(runs: Sequence[RecordedRun]) -> tuple[WallImpacts, Counter[str]]:
    """The usable impacts of all runs, and the number of others by reason.

    The normal is that of the world's nearest surface: from the change of velocity it could be found only if the
    tangential retention were known.
    """
    impacts, normals, left_out = [], [], Counter[str]()
    for run in runs:
        times = find_impacts(run.path.times, run.path.points, run.settings)
        for time in times:
            try:
                impact, normal = _measured_impact(run, time, times)
            except UnusableImpact as error:
                left_out[str(error)] += 1
                continue
            impacts.append(impact)
            normals.append(normal)
    usable, others = sorted_out(seen_from_walls(impacts, np.array(normals)))
    return usable, left_out + others


def _measured_impact(run: RecordedRun, time: float, times: Sequence[float]) -> tuple[ImpactFit, np.ndarray]:
    if sum(abs(other - time) < FAR for other in times) > 1:
        raise UnusableImpact(f"another hit within {FAR:g} s")
    impact = fit_impact(run.path, time, run.settings.robot, run.settings.mocap.position_noise)
    point, normal = nearest_surface(run.world, impact.position)
    # negated, because the point is NaN in a world without surfaces
    if not abs(np.linalg.norm(impact.position - point) - run.settings.robot.radius) <= FARTHEST_WALL:
        raise UnusableImpact("no surface of the world at the robot's rim")
    return impact, normal
