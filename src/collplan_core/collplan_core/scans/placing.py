"""Mounting pose of the LIDAR, and the pose of the sensor at each beam: every scan is placed here."""

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from collplan_core.parameters import ScanInput
from collplan_core.plane import rotate_rows
from collplan_core.poses.pose_history import PoseHistory, poses_along
from collplan_core.scan import Scan
from collplan_core.scans.filters import used_scan
from collplan_core.state import State


def poses_of_sensor(robot: np.ndarray, mount: tuple[float, float, float]) -> np.ndarray:
    """(n, 3) x, y [m] and yaw [rad], not wrapped, of a sensor on a robot at each of the poses `robot` (n, 3).

    At the centre of the robot these are its own poses, not a copy of them. Mount: x forward, y left [m], heading [rad].
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


def beam_poses(scan: Scan, poses: PoseHistory, mount: ScanInput) -> np.ndarray | None:
    """(n, 3) x, y [m] and yaw [rad], not wrapped, of the sensor at each beam, world frame.

    None where the robot's pose is not known, or not yet, at the instant of each of them.
    """
    state = poses.at(scan.stamp)
    if state is None:
        return None
    if scan.time_increment == 0.0:
        robot: np.ndarray | None = np.full((len(scan.ranges), 3), (*state.position.tolist(), state.yaw))
    else:
        robot = poses.at_each(_instants(scan))
    return None if robot is None else poses_of_sensor(robot, mount.offset)


def placed(scan: Scan, beams: np.ndarray, state: State, mount: ScanInput) -> Scan:
    """The scan with the poses of its sensor, which are `beams` (n, 3) in the world, seen from the robot at a state."""
    if scan.time_increment == 0.0 and not any(mount.offset):
        return scan
    return replace(scan, sensor_poses=seen_from_robot(beams, state))


def placed_among(scan: Scan, state: State, states: Collection[State], mount: ScanInput) -> Scan:
    """Returns the usable part of a recorded scan, with the sensor's poses; it waits for no pose.

    `state` is the robot at the stamp; `states` are around that time, in order, at least one. Beams beyond them are
    placed by the first or the last of them.
    """
    scan, robot = used_scan(scan, mount), poses_along(states, _instants(scan))
    return placed(scan, poses_of_sensor(robot, mount.offset), state, mount)


def _instants(scan: Scan) -> np.ndarray:
    """(n,) when each beam was measured [s]."""
    return scan.stamp + scan.time_increment * np.arange(len(scan.ranges))
