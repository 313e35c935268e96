"""Plausibility of heading, tilt and height of a measured pose, for a robot that drives on a floor.

A hit spins a disc by friction up to (1 - robot.inertia_factor) * max_speed / radius, 8.9 rad/s as shipped: then its rim
rolls along the wall. Simulated hits reach 5 rad/s. Nothing on a floor lifts or tips it.
"""

import math
from typing import NamedTuple

from collplan_core.parameters import Mocap

YAW, TILT, HEIGHT = "yaw", "tilt", "height"


STEEPEST, STEEPNESS, ROUGH, APART = math.radians(5.0), 0.03, 0.005, 0.05
"""Largest tilt of a motion capture's axes against the floor and its deviation [rad], of a height [m], and the distance
between the poses that are fitted [m]: a robot at rest shows no tilt."""


class Floor(NamedTuple):
    """The plane on which a robot drives, fitted to the heights of poses on it."""

    n: int  # number of poses
    x: float  # x, y, z: their means [m]
    y: float
    z: float
    xx: float  # xx, xy, yy, xz, yz: sums of the products of what they are off the means [m^2]
    xy: float
    yy: float
    xz: float
    yz: float
    last_x: float  # last_x, last_y: the newest of them [m]
    last_y: float

    def lift(self, x: float, y: float, height: float) -> float:
        """Returns how far a height [m] at x, y [m] is above the plane [m]; 0 before the first."""
        if self.n == 0:
            return 0.0
        stiff = (ROUGH / STEEPNESS) ** 2
        a, b, c = self.xx + stiff, self.xy, self.yy + stiff
        slope_x, slope_y = (c * self.xz - b * self.yz) / (a * c - b * b), (a * self.yz - b * self.xz) / (a * c - b * b)
        share = min(1.0, math.tan(STEEPEST) / max(math.hypot(slope_x, slope_y), 1e-9))
        return height - self.z - share * (slope_x * (x - self.x) + slope_y * (y - self.y))

    def is_new(self, x: float, y: float) -> bool:
        """Returns whether a pose at x, y [m] is to be fitted."""
        return self.n == 0 or math.hypot(x - self.last_x, y - self.last_y) >= APART

    def with_height(self, x: float, y: float, z: float) -> "Floor":
        """The plane with one more pose on it [m]."""
        n, dx, dy, dz = self.n + 1, x - self.x, y - self.y, z - self.z
        w = self.n / n
        means = self.x + dx / n, self.y + dy / n, self.z + dz / n
        sums = self.xx + w * dx * dx, self.xy + w * dx * dy, self.yy + w * dy * dy
        return Floor(n, *means, *sums, self.xz + w * dx * dz, self.yz + w * dy * dz, x, y)


NO_FLOOR = Floor(0, *(0.0,) * 10)


def tilt_of(quaternion: tuple[float, ...]) -> float:
    """Angle between the body's z axis and the vertical [rad], of a unit quaternion x, y, z, w."""
    x, y, _, _ = quaternion
    return 2.0 * math.asin(min(math.hypot(x, y), 1.0))


def why_off_floor(tilt: float, lift: float, mocap: Mocap) -> str:
    """TILT or HEIGHT where the robot is tipped by `tilt` [rad] or away from its floor by `lift` [m], else empty."""
    if tilt > mocap.max_tilt:
        return TILT
    return HEIGHT if abs(lift) > mocap.max_lift else ""


def turns(change: float, silence: float, mocap: Mocap) -> bool:
    """Returns whether a robot can turn by `change` [rad] between two poses that are `silence` [s] apart."""
    return abs(math.remainder(change, math.tau)) <= mocap.max_spin * silence + mocap.yaw_margin
