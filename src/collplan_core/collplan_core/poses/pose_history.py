"""The last poses, for the state of the robot at a scan's stamp."""

from bisect import bisect_left
from collections import deque
from collections.abc import Collection, Sequence
from math import remainder, tau

import numpy as np

from collplan_core.state import State


class PoseHistory:
    """Keeps the states of the last `span` [s], by their stamps."""

    def __init__(self, span: float) -> None:
        self._span = span
        self._states: deque[State] = deque()

    def add(self, state: State) -> None:
        """Adds the newest state; one that is not later than those kept begins anew, as after a clock was set back."""
        if self._states and state.stamp <= self._states[-1].stamp:
            self._states.clear()
        self._states.append(state)
        while self._states[0].stamp < state.stamp - self._span:
            self._states.popleft()

    def clear(self) -> None:
        """Drops every state, as after a relocation."""
        self._states.clear()

    def at(self, stamp: float) -> State | None:
        """Returns the state at `stamp` [s]; None outside of the span kept."""
        if not self._states or not self._states[0].stamp <= stamp <= self._states[-1].stamp:
            return None
        return state_at(self._states, stamp)

    def at_each(self, stamps: np.ndarray) -> np.ndarray | None:
        """(n, 3) x, y [m] and yaw [rad], not wrapped, at stamps (n,) [s]; None where one is outside."""
        if not self._states or stamps.min() < self._states[0].stamp or stamps.max() > self._states[-1].stamp:
            return None
        return poses_along(self._states, stamps)


def state_at(states: Sequence[State], stamp: float) -> State:
    """The state at a stamp [s] among states in order, at least one; the first or the last of them beyond.

    Between two states position and velocity are linear, and the yaw goes the shortest way.
    """
    after = bisect_left(states, stamp, key=lambda state: state.stamp)
    if after == len(states):
        return states[-1]
    if after == 0 or states[after].stamp == stamp:
        return states[after]
    return _between(states[after - 1], states[after], stamp)


def poses_along(states: Collection[State], stamps: np.ndarray) -> np.ndarray:
    """(n, 3) x, y [m] and yaw [rad], not wrapped, at stamps (n,) [s]: between states, and those at the ends beyond."""
    times = np.array([state.stamp for state in states])
    poses = np.array([(*state.position.tolist(), state.yaw) for state in states])
    columns = poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2])
    return np.column_stack([np.interp(stamps, times, column) for column in columns])


def _between(a: State, b: State, stamp: float) -> State:
    share = (stamp - a.stamp) / (b.stamp - a.stamp)
    return State(
        stamp=stamp,
        position=a.position + share * (b.position - a.position),
        velocity=a.velocity + share * (b.velocity - a.velocity),
        yaw=remainder(a.yaw + share * remainder(b.yaw - a.yaw, tau), tau),
    )
