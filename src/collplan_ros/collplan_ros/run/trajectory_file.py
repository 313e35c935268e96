"""trajectory.csv: the poses of a run, with command, tracked point and maneuver at each."""

import csv
import math
from pathlib import Path

from collplan_ros.run.run_log import PoseRow, RunLog

COLUMNS = ("t", "x", "y", "yaw", "vx", "vy", "cmd_vx", "cmd_vy", "cmd_wz", "ref_x", "ref_y", "maneuver")
UNKNOWN = math.nan


def write_trajectory(path: Path, log: RunLog) -> None:
    """Writes one row per pose: pose and velocity in the world frame, last command in the robot's frame, tracked point.

    t counts from the first non-zero command, so arrival_time_s is the last t of a run that reached its goal and lost no
    pose. Commands, points and maneuvers hold from the time they were sent, not received; the rows are therefore written
    after the run.
    """
    begin = log.begin
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for pose in log.poses:
            numbers = (pose.stamp - begin, *pose[1:6], *_commanded(pose, log))
            writer.writerow([*(f"{number:.6f}" for number in numbers), log.maneuver_at(pose.sent)])


def _commanded(pose: PoseRow, log: RunLog) -> tuple[float, ...]:
    command, reference = log.command_at(pose.sent), log.reference_at(pose.sent)
    return (*(command[1:] if command else (UNKNOWN,) * 3), *(reference[1:] if reference else (UNKNOWN,) * 2))
