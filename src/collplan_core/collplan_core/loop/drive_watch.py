"""The drive learnt in the controller: which poses count, and which drive planner and controller use."""

import math

import numpy as np

from collplan_core.command import STOPPED, Command
from collplan_core.control.base_faults import BaseFaults
from collplan_core.control.drive_record import OF_BODY, DriveRecord
from collplan_core.control.motion_monitor import LATE, REVERSED, SLIP, STUCK
from collplan_core.learning.drive import DRIVE, Drive, LearntDrive, drive_in_use, drive_of
from collplan_core.learning.drive_learner import DriveLearner
from collplan_core.parameters import Settings

AROUND = 0.06
"""Poses so near in time to a command that the wheels may not follow are left out [s]: it is longer than a period."""
GRABBED = 0.2
"""Time before a refused pose in which a hand may have held the robot [s]."""
NEARBY = 0.15
"""Distance of the ring from a surface seen within which a robot that has hit it is when that is reported [m]."""
SURE = 0.45
"""A change of velocity that no surface nearby explains is an impact from here on [m/s]: an impact is found where the
drive that is set cannot make the change, and this one may."""

FIRST = 1.5
"""Driving time before which nothing learnt is used [s]: in the first second late poses look like a weak drive, and the
monitor of the motion must find them."""


class DriveWatch:
    """Takes poses, impacts and commands; without `robot.learning` it does nothing."""

    def __init__(self, settings: Settings) -> None:
        """Begins with the drive that the parameters tell."""
        self._settings, self._learner = settings, _learner(settings)
        # the drive that planner and controller use; None is that of the parameters
        self.in_use: Drive | None = None if self._learner is None else self._learner.belief
        # the drive learnt up to the newest command; None where nothing is learnt, or not enough to be used
        self.learnt: LearntDrive | None = None
        self.faults = BaseFaults(settings.robot)  # what motion shows of the base, also where nothing is learnt
        self._newest = -math.inf

    def take_pose(self, drive: DriveRecord, joins: bool, pushed: bool) -> None:
        """Takes the newest pose: whether it joins the one before, and whether something may push that is no wheel."""
        _, self._newest, _, _, x, y, yaw = drive.motion[-1].tolist()
        self.faults.take_pose(drive, joins and not pushed)
        if self._learner is None:
            return
        if not joins:
            self._learner.begin_anew()
        if not pushed:
            self._learner.take_pose((self._newest, x, y, yaw), drive.told(OF_BODY))

    def refuse_pose(self) -> None:
        """Takes a pose that cannot be used, as where a hand lifts the robot."""
        if self._learner is not None:
            self._learner.exclude(self._newest - GRABBED, self._newest + AROUND)

    def take_impact(self, stamp: float, change: np.ndarray, nearby: bool) -> None:
        """Takes an impact at `stamp` [s], its change of velocity (2,) [m/s], and whether a surface seen is near."""
        if self._learner is not None and (nearby or float(np.hypot(*change)) > SURE):
            self._learner.take_impact(stamp)

    def commanded(self, command: Command, now: float | None, kind: str, robot_stands: str) -> bool:
        """Takes a command that is sent now [s, poses' clock]; returns whether another drive is used from now on.

        `kind` is the newest verdict on the motion, `robot_stands` why the robot does not follow it; "" where it does.
        """
        if self._learner is None or now is None:
            return False
        if kind == LATE and self._learner.driven > 0.0:
            # what was learnt of late poses is wrong
            self._learner = _learner(self._settings) or self._learner
        if robot_stands or command.maneuver == STOPPED or kind in (STUCK, SLIP, REVERSED):
            self._learner.exclude(now - AROUND, now + AROUND)
        belief, before = self._learner.belief, self.in_use or self._learner.belief
        self.learnt = self._learner.learnt if self._learner.driven >= FIRST else None
        self.in_use = belief if self.learnt is None else drive_in_use(belief, self.learnt, before)
        return self.in_use != before


def _learner(settings: Settings) -> DriveLearner | None:
    if settings.robot.learning != DRIVE:
        return None
    return DriveLearner(drive_of(settings.robot), settings.mocap.position_noise)
