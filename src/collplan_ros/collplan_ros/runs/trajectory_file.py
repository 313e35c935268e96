"""trajectory.csv: the poses of a run, and what the robot was told at each."""

import csv
import math
from pathlib import Path

from collplan_ros.runs.run_log import PoseRow, RunLog

COLUMNS = ("t", "x", "y", "yaw", "vx", "vy", "cmd_vx", "cmd_vy", "cmd_wz", "ref_x", "ref_y", "maneuver")
UNKNOWN = math.nan


def write_trajectory(path: Path, log: RunLog) -> None:
    """One row per pose: pose and velocity in the world frame, the last command in the body frame, the point tracked.

    t counts from the first non-zero command, so arrival_time_s is the last t of a run that reached its goal and
    lost no pose. What was told counts from when it was sent, whenever it was received: the rows can be made only once
    everything is there.
    """
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        begin = log.begin
        for pose in log.poses:
            numbers = (pose.stamp - begin, *pose[1:6], *_told(pose, log))
            writer.writerow([*(f"{number:.6f}" for number in numbers), log.maneuver_at(pose.sent)])


def _told(pose: PoseRow, log: RunLog) -> tuple[float, ...]:
    command, reference = log.command_at(pose.sent), log.reference_at(pose.sent)
    return (*(command[1:] if command else (UNKNOWN,) * 3), *(reference[1:] if reference else (UNKNOWN,) * 2))
