"""Mounting pose of the LIDAR, and with it the origin of each beam: every scan is placed here."""

import math

import numpy as np

from collplan_core.plane import rotate_rows
from collplan_core.state import State


def poses_of_sensor(robot: np.ndarray, mount: tuple[float, float, float]) -> np.ndarray:
    """(n, 3) x, y [m] and yaw [rad], not wrapped, of a sensor on a robot at each of the poses `robot` (n, 3).

    At the centre of the robot these are its own poses, not a copy of them.

    Args:
        robot: x, y [m] and yaw [rad] of the robot.
        mount: mounting pose of the sensor: x forward, y to the left [m], and heading [rad].
    """
    if not any(mount):
        return robot
    x, y, yaw = mount
    offsets = rotate_rows(np.tile((x, y), (len(robot), 1)), robot[:, 2])
    return np.column_stack([robot[:, :2] + offsets, robot[:, 2] + yaw])


def seen_from_robot(poses: np.ndarray, state: State) -> np.ndarray:
    """(n, 3) poses x, y [m] and yaw [rad] of the world frame in the frame of the robot at a state."""
    turns = poses[:, 2] - state.yaw
    # of a heading that is not wrapped the difference may be whole turns
    turns = turns - math.tau * np.round(turns[0] / math.tau)
    return np.column_stack([rotate_rows(poses[:, :2] - state.position, -state.yaw), turns])
