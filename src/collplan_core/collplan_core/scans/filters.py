"""Filters of a scan: masked angles and speckles are left out, angles are put in order, felt obstacles added."""

import math
from dataclasses import replace

import numpy as np

from collplan_core.parameters import ScanInput
from collplan_core.scan import Scan
from collplan_core.sight_lines import is_full_turn
from collplan_core.state import State


def in_time(scan: Scan, taken: ScanInput) -> Scan:
    """Returns a scan as its driver times it with its true stamp, order of beams and, where of one moment, no sweep."""
    between = 0.0 if taken.instant else scan.time_increment
    stamp = scan.stamp + taken.stamp_offset
    if taken.backwards:
        stamp, between = stamp + between * (len(scan.ranges) - 1), -between
    if (stamp, between) == (scan.stamp, scan.time_increment):
        return scan
    return replace(scan, stamp=stamp, time_increment=between)


def used_scan(scan: Scan, taken: ScanInput) -> Scan:
    """Returns the usable part of a scan; the scan itself where nothing is left out or turned over."""
    ranges = scan.ranges
    if taken.median > 1:
        ranges = without_speckles(ranges, taken.median, is_full_turn(len(ranges), scan.angle_increment))
    if taken.masked_angles:
        ranges = np.where(is_masked(scan.angles, taken.masked_angles), np.nan, ranges)
    if ranges is not scan.ranges:
        scan = replace(scan, ranges=ranges)
    return upside_down(scan) if taken.mirrored else scan


def masked_beams(scan: Scan, taken: ScanInput) -> np.ndarray:
    """(n,) whether each beam of a scan, of which `used_scan` left what is used, is masked."""
    if not taken.masked_angles:
        return np.zeros(len(scan.ranges), bool)
    return is_masked(-scan.angles if taken.mirrored else scan.angles, taken.masked_angles)


def upside_down(scan: Scan) -> Scan:
    """The scan of a sensor turned over: its angles count the other way round."""
    return replace(scan, angle_min=-scan.angle_min, angle_increment=-scan.angle_increment)


def is_masked(angles: np.ndarray, masked: tuple[float, ...]) -> np.ndarray:
    """(n,) whether each of the angles (n,) [rad] lies in one of the intervals from, to, from, to, ... [rad].

    An interval goes counter-clockwise from its first angle to its second, over any multiple of a full turn.
    """
    found = np.zeros(len(angles), bool)
    for begin, end in zip(masked[::2], masked[1::2], strict=True):
        # a mask of a whole turn is not one of nothing
        width = end - begin if 0.0 <= end - begin <= math.tau else (end - begin) % math.tau
        found |= (angles - begin) % math.tau <= width
    return found


def without_speckles(ranges: np.ndarray, width: int, closed: bool) -> np.ndarray:
    """(n,) the median of the `width` ranges around each [m], odd; NaN stays NaN, and is not counted beside others.

    It leaves a wall and the edge where it ends as they are, and takes away what less than half of the beams show. Of an
    even number of ranges it is the nearer one: no range is made up. Where the scan is not `closed`, there are fewer
    beams at the ends.
    """
    half = width // 2
    beyond = ranges[-half:], ranges[:half]
    padded = np.concatenate([beyond[0], ranges, beyond[1]] if closed else [[np.nan] * half, ranges, [np.nan] * half])
    around = np.sort(np.lib.stride_tricks.sliding_window_view(padded, width), axis=1)
    counted = (~np.isnan(around)).sum(axis=1)
    middle = around[np.arange(len(ranges)), np.maximum(counted - 1, 0) // 2]
    return np.where(np.isnan(ranges), np.nan, middle)


def add_bumped_obstacles(scan: Scan, state: State, centers: np.ndarray, radius: float) -> Scan:
    """The scan, taken at `state`, with discs at `centers` (n, 2) [m] added, but for one that contains the robot."""
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
