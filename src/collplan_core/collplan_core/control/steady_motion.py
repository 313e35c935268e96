"""Detects a base that cannot drive sideways, from its motion under commands that last."""

from collections import deque

import numpy as np

from collplan_core.plane import rotate
from collplan_core.state import State

HELD, PERIOD = 0.3, 0.04
"""Time looked back: longer than lag and delay; and between two poses that are kept [s]."""
SIDEWAYS, ENOUGH = 0.15, 0.3
"""Command along an axis that counts [m/s], and time for which motion must show how it is followed [s]."""
NONE, SOME = 0.2, 0.5
"""Shares of the commands up to which a base does not follow along y, and from which it does along x."""


class SteadyMotion:
    """Takes commands and poses in the order of time, all times on the poses' clock [s]."""

    def __init__(self) -> None:
        """Starts without any."""
        self._commands = deque[tuple[float, float, float]]()
        self._motion = deque[tuple[float, float, float]]()
        self._times = {"x": 0.0, "y": 0.0}
        self._shares = {"x": 1.0, "y": 1.0}

    def take_command(self, velocity: np.ndarray, now: float) -> None:
        """Takes a velocity (2,) [m/s, body frame] that is sent now."""
        self._commands.append((now, *velocity.tolist()))

    def take_pose(self, state: State, free: bool) -> None:
        """Takes a pose; `free` where nothing but the wheels moves the robot, and it joins the one before."""
        if not free:
            self._motion.clear()
            return
        since = state.stamp - self._motion[-1][0] if self._motion else PERIOD
        if since < PERIOD:
            return
        self._motion.append((state.stamp, *rotate(*state.velocity.tolist(), -state.yaw)))
        while self._motion[0][0] < state.stamp - HELD - PERIOD:
            self._motion.popleft()
        while len(self._commands) > 1 and self._commands[1][0] <= state.stamp - HELD:
            self._commands.popleft()
        begin = state.stamp - HELD
        if self._commands and self._commands[0][0] <= begin and self._motion[0][0] <= begin:
            self._judge(np.array(self._commands)[:, 1:], np.array(self._motion)[:, 1:], min(since, HELD))

    def _judge(self, told: np.ndarray, moved: np.ndarray, lasted: float) -> None:
        """Takes commands (n, 2) and motion (m, 2) of the last HELD [m/s, body frame]; the newest lasted so long [s]."""
        for k, axis in enumerate(("x", "y")):
            asked = told[:, k]
            if min(abs(asked)) >= SIDEWAYS and abs(np.sign(asked).sum()) == len(asked):
                self._times[axis] += lasted
                share = float(moved[:, k].mean() / asked.mean())
                self._shares[axis] += min(lasted / self._times[axis], 1.0) * (share - self._shares[axis])

    @property
    def why_unlike(self) -> str:
        """Sentence on a base that does not drive sideways; "" where it does, or nothing is known yet."""
        times, share = self._times, self._shares
        if min(times.values()) >= ENOUGH and share["y"] < NONE and share["x"] > SOME:
            return "moves along x alone: can the base drive sideways?"
        return ""
