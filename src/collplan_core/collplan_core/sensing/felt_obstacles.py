"""Bumped obstacles, which no scan showed: discs where the robot got stuck, added to scans as if they were seen."""

from dataclasses import replace

import numpy as np

from collplan_core.scan import Scan
from collplan_core.state import State


def add_bumped_obstacles(scan: Scan, state: State, centers: np.ndarray, radius: float) -> Scan:
    """The scan with discs added to what it shows.

    Args:
        state: the robot at the scan's stamp.
        centers: (n, 2) of the discs, world frame [m].
        radius: radius of the discs [m]; a disc that contains the robot is left out.
    """
    if len(centers) == 0:
        return scan
    ranges = np.array(scan.ranges, dtype=float)
    origins, bearings = scan.beams(state)
    ahead, aside = np.cos(bearings), np.sin(bearings)
    for center in centers:
        if ((center - state.position) ** 2).sum() <= radius * radius:
            continue
        # where beams meet the circle: the nearer root
        x, y = (center - origins).T
        along = x * ahead + y * aside
        outside = x * x + y * y - radius * radius
        reach = along**2 - outside
        met = (reach >= 0.0) & (along > 0.0) & (outside > 0.0)
        near = along - np.sqrt(np.maximum(reach, 0.0))
        ranges = np.where(met & ~(ranges <= near), near, ranges)
    return replace(scan, ranges=ranges)
