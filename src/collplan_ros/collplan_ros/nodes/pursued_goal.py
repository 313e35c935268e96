"""The goal that planner_node pursues: given, reached, or ended for another reason."""

from dataclasses import replace

import numpy as np
from action_msgs.msg import GoalStatus
from rclpy.node import Node

from collplan_core.state import State
from collplan_ros.messages import qos
from collplan_ros.node_kit.run_node import publish_acknowledged
from collplan_ros.nodes.goal_status import Goal, goal_to_status

CLOSED_OFF_TIME = 2.0
"""A goal closed off for so long is given up [s]."""


class PursuedGoal:
    """Publishes goal_status at every change; begins without a goal, whatever a planner before this one left active."""

    def __init__(self, node: Node) -> None:
        """Publishes by `node`."""
        self._log = node.get_logger()
        self._out = node.create_publisher(GoalStatus, "goal_status", qos.LATCHED)
        self._goal: Goal | None = None
        self._since: float | None = None
        self._closed_since: float | None = None
        self._out.publish(GoalStatus(status=GoalStatus.STATUS_UNKNOWN))

    @property
    def active(self) -> bool:
        """Whether the robot is to go there."""
        return self._goal is not None and self._goal.active

    @property
    def position(self) -> np.ndarray:
        """(2,) of the newest goal [m]; there must be one."""
        assert self._goal is not None
        return self._goal.position

    @property
    def status_name(self) -> str:
        """The status in a word."""
        return "none" if self._goal is None else self._goal.status_name

    def take(self, position: np.ndarray, stamp: float, now: float | None) -> None:
        """A new goal (2,) [m]; its plans are later than `stamp` [s], and its time runs from `now` [s, poses' clock]."""
        self._since, self._closed_since = now, None
        self._announce(Goal(stamp, position))
        self._log.info(f"goal {position[0]:.3f}, {position[1]:.3f} accepted")

    def refuse(self, stamp: float) -> None:
        """What came is no goal; the one before has ended all the same."""
        self._announce(Goal(stamp, np.full(2, np.nan), GoalStatus.STATUS_ABORTED))

    def set_status(self, status: int) -> None:
        """One of GoalStatus.STATUS_*, of the newest goal."""
        assert self._goal is not None
        if status != self._goal.status:
            self._announce(replace(self._goal, status=status))
            self._log.info(f"goal {self.status_name}")

    def begin_anew(self, stamp: float) -> None:
        """The poses begin anew at `stamp` [s]: an active goal stays, plans of before do not."""
        if self._goal is None or not self._goal.active:
            return
        if self._since is not None:  # the poses' clock may have been set back
            self._since = min(self._since, stamp)
        self._closed_since = None
        self._announce(replace(self._goal, stamp=stamp))

    def is_reached(self, state: State, tolerance: float) -> bool:
        """Whether the robot is within `tolerance` [m] of an active goal."""
        return self.active and float(np.hypot(*(state.position - self.position))) <= tolerance

    def is_overdue(self, now: float | None, timeout: float) -> bool:
        """Whether it was not reached within `timeout` [s]; 0 is never."""
        if self._since is None:  # no pose had come
            self._since = now
        return bool(timeout) and now is not None and self._since is not None and now - self._since > timeout

    def planned(self) -> None:
        """There is a plan."""
        self._closed_since = None
        self.set_status(GoalStatus.STATUS_EXECUTING)

    def is_closed_off(self, local: float) -> bool:
        """There is no way at `local` [s, local clock]; whether so for CLOSED_OFF_TIME."""
        if self._closed_since is None:
            self._closed_since = local
        return local - self._closed_since >= CLOSED_OFF_TIME

    def end(self) -> None:
        """Cancels an active goal and waits until listeners know."""
        if self._goal is not None and self._goal.active:
            self._goal = replace(self._goal, status=GoalStatus.STATUS_CANCELED)
            publish_acknowledged(self._out, goal_to_status(self._goal))

    def _announce(self, goal: Goal) -> None:
        self._goal = goal
        self._out.publish(goal_to_status(goal))
