"""Plausibility of heading, tilt and height of a measured pose, for a robot that drives on a floor.

A hit spins a disc by friction up to (1 - robot.inertia_factor) * max_speed / radius, 8.9 rad/s as shipped: then its rim
rolls along the wall. Simulated hits reach 5 rad/s. Nothing on a floor lifts or tips it.
"""

import math

from collplan_core.parameters import Mocap

YAW, TILT, HEIGHT = "yaw", "tilt", "height"


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
