"""trajectory.csv, written as the run goes."""

import csv
import math
from pathlib import Path

from collplan_core.command import STOPPED
from collplan_ros.run_log import PoseRow, RunLog

COLUMNS = ("t", "x", "y", "yaw", "vx", "vy", "cmd_vx", "cmd_vy", "cmd_wz", "ref_x", "ref_y", "maneuver")
UNKNOWN = math.nan


class TrajectoryFile:
    """One row per pose: pose and velocity in the world frame, the last command in the body frame, the point tracked.

    t counts from the first pose; no reference is tracked while the robot is stopped.
    """

    def __init__(self, path: Path) -> None:
        """Writes the header."""
        self._file = path.open("w", newline="", buffering=1)  # by line: what was written survives a kill
        self._writer = csv.writer(self._file)
        self._writer.writerow(COLUMNS)

    def add(self, pose: PoseRow, log: RunLog) -> None:
        """Writes the row of the newest pose."""
        command = log.commands[-1][2:5] if log.commands else (UNKNOWN,) * 3
        tracked = log.reference if log.maneuver != STOPPED else None
        reference = tracked or (UNKNOWN, UNKNOWN)
        numbers = (pose.stamp - log.poses[0].stamp, *pose[1:], *command, *reference)
        self._writer.writerow([*(f"{number:.6f}" for number in numbers), log.maneuver])

    def close(self) -> None:
        """Ends the file."""
        self._file.close()
