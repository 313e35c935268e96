"""Monitoring of the robot's motion in the controller, and the verdict on it."""

import math

import numpy as np

from collplan_core.command import FREE_SPACE, Command
from collplan_core.control.brush import LASTS, Brush, judge_brush
from collplan_core.control.drive_record import DriveRecord
from collplan_core.control.motion_monitor import (
    SETTLE,
    STOPPING,
    UNSEEN,
    MotionRecord,
    MotionVerdict,
    add_command,
    add_pose,
    ignore_until,
    judge_motion,
    restart,
)
from collplan_core.jit import njit
from collplan_core.movers.record import NO_MOVERS, Movers
from collplan_core.parameters import Settings
from collplan_core.scan import Scan
from collplan_core.state import State

TOUCH = 0.03
"""Distance of the ring from a surface seen within which that may push: noise of poses and ranges, and their age [m]."""
HIT_TIME = 0.05
"""A hit of an unseen obstacle shows as a change of velocity within this time [s]..."""
HIT = 0.25
"""...by so much more than the wheels make; less may be noise [m/s]."""
TURNED = 0.2
"""Time for which a mover may have gone another way than it is predicted to [s]."""
NEARBY = 0.5
"""Surfaces farther from the ring than this are not kept: they are seen again before they are near [m]."""


class MotionWatch:
    """Takes poses, scans and commands, each with the local time [s]; judges the motion each period."""

    def __init__(self) -> None:
        """Starts without poses, scans or commands."""
        self.verdict = MotionVerdict()  # the newest
        self.pushed = False  # whether something else than the wheels may have moved the robot at the newest pose
        self.brush = Brush()  # a verdict that a contact explains, put off
        self.drive = DriveRecord()  # what was commanded and how the robot moved since the poses began anew
        self._record = MotionRecord()
        self._surfaces = np.zeros((0, 2))
        self._touched = self._brushed = -math.inf

    def forget(self) -> None:
        """Forgets everything but the delay, as where a standing robot starts to drive."""
        self.verdict = MotionVerdict(delay=self._record.delay)
        self._record = MotionRecord(self.drive.forgotten(), delay=self._record.delay)

    def take_pose(
        self, state: State, local: float, joins: bool, settings: Settings, movers: Movers = NO_MOVERS
    ) -> None:
        """Takes a pose, and what moves by then; a pose that does not join the earlier ones begins anew."""
        if not joins:
            self.drive, self._record = self.drive.forgotten(), restart(self._record)
        self.drive = self.drive.with_pose(state, local)
        beside = _is_beside(movers, state, settings)
        touching = self.is_near(state, settings.robot.radius + TOUCH) or beside
        self.pushed = touching
        if touching:
            self._touched = local
        elif local - self._touched > SETTLE and self._is_hit(state, settings):
            self.pushed = True
            self._record = ignore_until(self._record, local + UNSEEN)
            beside = True
        self._brushed = local if beside else self._brushed
        self._record = add_pose(self._record, self.drive, touching)

    def is_near(self, state: State, reach: float) -> bool:
        """Returns whether a surface of the newest scan is within `reach` of the centre [m]."""
        return _is_near(self._surfaces, *state.position.tolist(), reach)

    def _is_hit(self, state: State, settings: Settings) -> bool:
        """Returns whether this pose shows a hit."""
        motion = self._record.motion
        before = motion[motion[:, 1].searchsorted(state.stamp - HIT_TIME - 1e-6, side="right") :]
        if len(before) == 0:
            return False
        change = math.dist(state.velocity.tolist(), before[0, 2:4].tolist())
        return change > settings.robot.max_acceleration * HIT_TIME + HIT

    def take_scan(self, placed: tuple[Scan, State] | None, settings: Settings) -> None:
        """Takes the newest scan whose pose is known, and that pose."""
        if placed is None:
            return
        scan, state = placed
        near = np.isfinite(scan.ranges) & (scan.ranges < settings.robot.radius + NEARBY)
        self._surfaces = np.ascontiguousarray(scan.points(state, near))

    def judge(self, now: float, settings: Settings) -> None:
        """Judges the motion up to `now` [s]."""
        self.verdict, self._record = judge_motion(self._record, now, settings)

    def why_hold(self, now: float, settings: Settings) -> str:
        """Returns the verdict for which the robot is to be held at `now` [s]; "" where it is not, or not yet."""
        why, was_put_off = self.verdict.reason if self.verdict.kind in STOPPING else "", bool(self.brush.why)
        if why and not was_put_off and now - self._brushed > UNSEEN + LASTS:
            return why
        self.brush = judge_brush(self.brush, why, self._record, now, settings)
        if was_put_off and not self.brush.why and not self.brush.held:
            self.forget()
        return self.brush.held

    def commanded(self, command: Command, local: float) -> None:
        """Takes a command that is sent now."""
        self.drive = self.drive.with_command(command.velocity, local)
        self._record = add_command(self._record, self.drive)


def _is_beside(movers: Movers, state: State, settings: Settings) -> bool:
    """Returns whether a mover may touch the robot: it is in no surface, and may have turned since it was seen."""
    if len(movers) == 0:
        return False
    rows = movers.rows_at(state.stamp)
    apart = np.hypot(*(rows[:, :2] - state.position).T) - rows[:, 4] - settings.robot.radius
    return bool((apart < TOUCH + TURNED * np.hypot(*rows[:, 2:4].T)).any())


@njit
def _is_near(points: np.ndarray, x: float, y: float, reach: float) -> bool:
    """Returns whether one of the points (n, 2) is within `reach` of (x, y) [m]."""
    for k in range(len(points)):
        dx, dy = points[k, 0] - x, points[k, 1] - y
        if dx * dx + dy * dy < reach * reach:
            return True
    return False


def warm_up() -> None:
    """Compiles the judgement of motion, so that neither pose nor command has to wait for it."""
    watch, settings = MotionWatch(), Settings()
    for k in range(40):
        watch.take_pose(State(0.01 * k, np.zeros(2), np.zeros(2), 0.0), 0.01 * k, True, settings)
        watch.commanded(Command(np.array([0.1, 0.0]), 0.0, FREE_SPACE, np.zeros(2)), 0.01 * k)
    watch.judge(0.4, settings)
