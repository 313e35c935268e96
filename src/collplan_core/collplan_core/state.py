"""The robot's position, velocity and heading at one instant."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from collplan_core.validation import finite


@dataclass(frozen=True, eq=False)
class State:
    """The robot at one instant, world frame."""

    stamp: float  # time on the poses' clock [s]
    position: np.ndarray  # (2,) centre of the disc [m]
    velocity: np.ndarray  # (2,) [m/s]
    yaw: float  # heading of the body [rad]; the paper's theta is the direction of `velocity`, never this

    @classmethod
    def at_rest(cls, position: Sequence[float] | np.ndarray, yaw: float = 0.0, stamp: float = 0.0) -> "State":
        """A robot that rests at a position (2,) [m] with a heading [rad]; ValueError where that is no position."""
        return cls(stamp, finite("position", position, (2,), "expected x, y [m]"), np.zeros(2), yaw)
