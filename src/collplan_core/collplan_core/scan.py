"""A LIDAR scan as the local map takes it, checked where it enters."""

from dataclasses import dataclass
from math import inf, isfinite, isnan, nan

import numpy as np

from collplan_core.jit import njit
from collplan_core.plane import rotate_rows
from collplan_core.state import State


class ScanError(ValueError):
    """A scan that cannot be used; the message names the value and what was expected."""


MARK = 1.001
"""Filters write range_max + 1 for beams that they take away: no other unit makes ranges so little above it [m]."""
ROUNDED = 1e-6
"""Share of range_max by which a range may differ and still be it: messages round both."""
FARTHEST = 1000.0
"""No LIDAR sees farther; much larger numbers stand for no limit [m]."""
CODES = 3
"""Most numbers above range_max that may be codes of a device, where most beams have one."""


@njit
def _apply_limits(ranges: np.ndarray, low: float, high: float) -> tuple[float, int, int]:
    """The smallest finite range, inf without one, and the numbers of beams that measured anything, and too much."""
    # REP-117: what a device reports outside its limits is no measurement of a distance; it is replaced in place. What
    # is nearer is near, range_max itself is nothing within it, and what is above is lost.
    smallest, measured, beyond = inf, 0, 0
    for i in range(len(ranges)):
        if isnan(ranges[i]):
            continue
        if isfinite(ranges[i]) and ranges[i] > high * (1.0 + ROUNDED):
            beyond += ranges[i] > high + MARK
            ranges[i] = nan
            continue
        measured += 1
        if isfinite(ranges[i]):
            smallest = min(smallest, ranges[i])
            if ranges[i] < low:
                ranges[i] = -inf
            elif ranges[i] >= high * (1.0 - ROUNDED):
                ranges[i] = inf
    return smallest, measured, beyond


@dataclass(frozen=True, eq=False)
class Scan:
    """One turn of the LIDAR (REP-117).

    Raises:
        ScanError: wrong shape, fewer than 2 beams, more than a full turn, bad limits, negative ranges, most
            ranges above them, or not a single valid range.
    """

    stamp: float  # time of the first beam on the poses' clock [s]
    angle_min: float  # direction of the first beam [rad, sensor frame]
    angle_increment: float  # step from beam to beam [rad], not zero
    range_min: float  # range_min, range_max: limits of a valid range [m]; a range_max of inf is none
    range_max: float
    ranges: np.ndarray
    """(n,) [m]; +Inf nothing within range_max, -Inf below range_min, NaN not measured or given above range_max."""
    time_increment: float = 0.0
    """Time from beam to beam [s], below 0 where later ones were measured before; 0 where all are of one instant."""
    sensor_poses: np.ndarray | None = None
    """(n, 3) x, y [m] and yaw [rad] of the sensor at each beam, in the robot's frame at the stamp; None where all are
    those of the robot at the stamp."""

    def __repr__(self) -> str:
        nearest = self.ranges.min(initial=inf, where=np.isfinite(self.ranges))
        return f"Scan({len(self.ranges)} beams at {self.stamp:g} s, nearest {nearest:.2f} m)"

    def __post_init__(self) -> None:
        ranges = np.array(self.ranges, dtype=np.float64)
        if ranges.ndim != 1 or len(ranges) < 2:
            raise ScanError(f"ranges: got shape {ranges.shape}, expected at least 2 beams in one row")
        if not all(map(isfinite, (self.stamp, self.angle_min, self.angle_increment))) or self.angle_increment == 0.0:
            raise ScanError(
                f"angles: got angle_min {self.angle_min}, angle_increment {self.angle_increment}, "
                "expected finite numbers and a step other than 0"
            )
        if not isfinite(self.time_increment):
            raise ScanError(f"time_increment: got {self.time_increment}, expected a finite time")
        if abs(self.angle_increment) * (len(ranges) - 1) > 2 * np.pi + 1e-3:
            raise ScanError(f"angles: {len(ranges)} beams of {self.angle_increment} rad, expected at most a full turn")
        if not (0.0 <= self.range_min < self.range_max):
            raise ScanError(
                f"limits: got range_min {self.range_min}, range_max {self.range_max}, "
                "expected finite numbers, 0 <= range_min < range_max; inf is no largest range"
            )
        if FARTHEST < self.range_max < 1000.0 * FARTHEST:
            raise ScanError(f"limits: got range_max {self.range_max:g} m: millimetres?")
        if self.sensor_poses is not None and self.sensor_poses.shape != (len(ranges), 3):
            raise ScanError(f"sensor_poses: got shape {self.sensor_poses.shape}, expected {(len(ranges), 3)}")
        given = ranges.copy()
        smallest, measured, beyond = _apply_limits(ranges, self.range_min, self.range_max)
        if beyond and 2 * beyond > np.isfinite(given).sum() and len(np.unique(given[given > self.range_max])) > CODES:
            raise ScanError(f"ranges: {beyond} of {len(given)} above range_max {self.range_max:g}: millimetres?")
        if smallest < 0.0:
            raise ScanError(f"ranges: got {smallest}, expected no negative range")
        if measured == 0:
            raise ScanError(f"ranges: all {len(ranges)} are NaN or above range_max, expected at least one measurement")
        ranges.flags.writeable = False
        object.__setattr__(self, "ranges", ranges)

    @property
    def angles(self) -> np.ndarray:
        """(n,) beam directions [rad, sensor frame]."""
        return self.angle_min + self.angle_increment * np.arange(len(self.ranges))

    @property
    def sweep(self) -> float:
        """Time from the first beam to the last [s]."""
        return abs(self.time_increment) * (len(self.ranges) - 1)

    def beams(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Each beam's origin (n, 2), (1, 2) if shared [m], bearing (n,) [rad], world frame; `state` at the stamp."""
        if self.sensor_poses is None:
            return state.position[np.newaxis], self.angles + state.yaw
        return (
            state.position + rotate_rows(self.sensor_poses[:, :2], state.yaw),
            self.angles + state.yaw + self.sensor_poses[:, 2],
        )

    def points(self, state: State, which: np.ndarray) -> np.ndarray:
        """Returns the end points (m, 2) [m, world frame] of the beams in a mask (n,), all of them of finite range."""
        origins, bearings = self.beams(state)
        if len(origins) > 1:
            origins = origins[which]
        ends = np.column_stack([np.cos(bearings[which]), np.sin(bearings[which])])
        return origins + self.ranges[which, np.newaxis] * ends
