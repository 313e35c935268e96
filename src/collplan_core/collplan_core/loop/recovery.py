"""Recovery of a robot that is stuck: it backs out, and treats the place as an obstacle from then on."""

import math
from collections import deque

import numpy as np

from collplan_core.control.back_out import DISTANCE, back_out
from collplan_core.control.drive_record import BY_STAMP, DriveRecord
from collplan_core.control.stuck import why_stuck
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.state import State


def way_left(plan: Plan, goal: np.ndarray, max_speed: float) -> tuple[float, float]:
    """Way [m] and time [s] from the start of a plan to a goal (2,) [m]: along the plan, then straight at `max_speed`.

    A plan that ends before the goal knows of no detour from there on: both are then too small rather than too large.
    """
    along = float(np.hypot(*np.diff(plan.positions, axis=0).T).sum())
    beyond = math.dist(plan.positions[-1], goal)
    return along + beyond, float(plan.times[-1]) - plan.stamp + beyond / max_speed


STEP = 0.01
"""Spacing of the places on the trail [m]."""
LONGEST_TRAIL = 200
"""Places kept on it."""


class Recovery:
    """The trail of the robot, whether it is stuck, and its tries and bumped obstacles since the goal was accepted."""

    def __init__(self) -> None:
        """Starts without a trail."""
        self.drive = DriveRecord()  # what was commanded and how the robot moved since the poses began anew
        self._recent = self.drive  # that of it in which the robot may be stuck
        self._trail: deque[tuple[float, float]] = deque(maxlen=LONGEST_TRAIL)
        self.begin_goal()

    def begin_goal(self) -> None:
        """Counts anew. Recent motion is kept: goals in quick succession would otherwise hide a stuck robot."""
        self.tries = 0  # number of times that it was stuck
        self.forget_felt()
        self.repeat_goal()

    def repeat_goal(self) -> None:
        """Takes the same goal again: the plan that backs out is void, as all earlier plans, and the rest continues."""
        self._until = -np.inf

    def forget(self) -> None:
        """Drops the trail and bumped obstacles, as after a break in the poses; the tries still count."""
        self._trail.clear()
        self._until = -np.inf
        self.forget_felt()
        self.drive = self._recent = self.drive.forgotten()

    def led_by_hand(self) -> None:
        """Notes that a person drives: a robot pushed against something by hand is not stuck."""
        self._until = -np.inf
        self._recent = self.drive.forgotten()

    def forget_felt(self) -> None:
        """Drops bumped obstacles: only seen ones count."""
        self.felt = np.zeros((0, 2))  # (n, 2) centres of bumped obstacles, discs of the robot's radius, world frame [m]

    def is_backing_out(self, now: float) -> bool:
        """Returns whether the plan that backs out is in force at `now` [s, poses' clock]."""
        return now < self._until

    def commanded(self, velocity: np.ndarray, local: float) -> None:
        """Takes a velocity (2,) [m/s, body frame] commanded from `local` on [s, local clock]."""
        self.drive = self.drive.with_command(velocity, local)

    def moved(self, state: State, local: float, settings: Settings) -> str:
        """Takes a pose; returns why the robot is stuck, or "". A command older than limits.command_age is ignored."""
        x, y = state.position.tolist()
        if not self.is_backing_out(state.stamp) and self._is_farther(x, y):
            self._trail.append((x, y))
        self.drive = self.drive.with_pose(state, local)
        self._recent = self.drive.since(self._recent)
        motion, commands = self._recent.motion, self._recent.told(BY_STAMP)
        if len(commands) == 0 or state.stamp - commands[-1, 0] > settings.limits.command_age:
            return ""
        return why_stuck(motion.take((1, 4, 5), axis=1), commands, settings.robot.max_acceleration)

    def _is_farther(self, x: float, y: float) -> bool:
        return not self._trail or math.dist((x, y), self._trail[-1]) >= STEP

    def begin(self, state: State, settings: Settings) -> Plan | None:
        """Returns the plan that backs out; None where the robot was backing out already: then any other way will do."""
        robot, was_backing_out = settings.robot, self.is_backing_out(state.stamp)
        commands = self._recent.told(BY_STAMP)[:, 1:]
        pushed = np.vstack([np.zeros((1, 2)), commands[commands.any(axis=1)]])[-1]
        ahead = pushed / max(float(np.hypot(*pushed)), 1e-9)
        self.felt = np.vstack([self.felt, state.position + 2.0 * robot.radius * ahead])
        self.tries += 1
        plan = None if was_backing_out else back_out(state, np.array(self._trail), pushed, robot.max_speed)
        self._until = -np.inf if plan is None else float(plan.times[-1])
        for _ in range(min(round(DISTANCE / STEP), len(self._trail))):
            self._trail.pop()
        self._recent = self.drive.forgotten()
        return plan
