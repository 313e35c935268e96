"""States and impacts in the frame of an odometry, moved to the map by the transform of a localisation."""

import math
from dataclasses import dataclass, replace

import numpy as np

from collplan_core.impact import Impact
from collplan_core.plane import rotate
from collplan_core.state import State


@dataclass(frozen=True)
class FrameInMap:
    """Pose of the odometry's frame in the map: x, y [m] and yaw [rad]."""

    x: float
    y: float
    yaw: float

    def position(self, point: np.ndarray) -> np.ndarray:
        """A point (2,) of the frame, in the map [m]."""
        return self.vector(point) + np.array((self.x, self.y))

    def vector(self, along: np.ndarray) -> np.ndarray:
        """A vector (2,) of the frame along the map's axes."""
        return np.array(rotate(float(along[0]), float(along[1]), self.yaw))


def moved_state(state: State, frame: FrameInMap) -> State:
    """The state in the map."""
    yaw = math.remainder(state.yaw + frame.yaw, math.tau)
    return State(state.stamp, frame.position(state.position), frame.vector(state.velocity), yaw)


def moved_impact(impact: Impact, frame: FrameInMap) -> Impact:
    """The impact in the map."""
    return replace(
        impact,
        point=frame.position(impact.point),
        normal=frame.vector(impact.normal),
        velocity_before=frame.vector(impact.velocity_before),
        velocity_after=frame.vector(impact.velocity_after),
    )
