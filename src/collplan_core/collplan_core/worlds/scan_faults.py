"""What drivers and surfaces make of a simulated scan on request, values of `lidar.fault`: real LIDARs do all of it."""

import math
from dataclasses import replace

import numpy as np

from collplan_core.scan import Scan
from collplan_core.sight_lines import is_full_turn

FLATTEST = math.radians(10.0)
"""Angle between a beam and a surface below which nothing comes back [rad]."""
RENEWED = 0.15
"""Period of the sensor that a driver polls more often [s]."""


def returned(ranges: np.ndarray, increment: float, fault: str) -> np.ndarray:
    """(n,) exact ranges (n,) [m] of beams `increment` [rad] apart, with `flat` +Inf where a surface is met flatly."""
    if fault != "flat":
        return ranges
    finite = np.where(np.isfinite(ranges), ranges, 0.0)
    rises = np.diff(finite, append=finite[0] if is_full_turn(len(ranges), increment) else finite[-1])
    steep = np.where(np.abs(rises) * math.tan(FLATTEST) > finite * abs(increment), np.sign(rises), 0.0)
    # at an edge one step alone is as large
    return np.where((steep != 0.0) & (steep == np.roll(steep, 1)), np.inf, ranges)


def published(scan: Scan, before: Scan | None, fault: str) -> Scan:
    """The scan as a driver gives it, which gave `before` last."""
    if fault == "zeros":
        # a scan keeps a 0 as it is only where no range is too near
        return replace(scan, range_min=0.0, ranges=np.where(np.isfinite(scan.ranges), scan.ranges, 0.0))
    if fault == "repeats" and before is not None and scan.stamp // RENEWED == before.stamp // RENEWED:
        return replace(scan, ranges=before.ranges)
    return scan
