"""The goal of planner_node, from acceptance until it is reached or ends for another reason."""

from dataclasses import replace

import numpy as np
from action_msgs.msg import GoalStatus
from rclpy.node import Node

from collplan_core.state import State
from collplan_ros.messages import qos
from collplan_ros.node_kit.run_node import publish_acknowledged
from collplan_ros.nodes.goal_status import StampedGoal, goal_to_status

CLOSED_OFF_TIME = 2.0
"""A goal that cannot be reached in the known map for this long is given up [s]."""


class CurrentGoal:
    """The newest goal, if any, and its status; publishes goal_status at every change.

    Starts without a goal and publishes that, in case a planner that ran earlier left one active.
    """

    def __init__(self, node: Node) -> None:
        """Publishes through `node`."""
        self._log = node.get_logger()
        self._out = node.create_publisher(GoalStatus, "goal_status", qos.LATCHED)
        self._goal: StampedGoal | None = None
        self._since: float | None = None
        self._closed_since: float | None = None
        self._out.publish(GoalStatus(status=GoalStatus.STATUS_UNKNOWN))

    @property
    def active(self) -> bool:
        """Whether there is a goal that the robot is to go to."""
        return self._goal is not None and self._goal.active

    @property
    def position(self) -> np.ndarray:
        """Position of the newest goal (2,) [m]; there must be one."""
        assert self._goal is not None
        return self._goal.position

    @property
    def status_name(self) -> str:
        """Name of the status; "none" without a goal."""
        return "none" if self._goal is None else self._goal.status_name

    def accept(self, position: np.ndarray, stamp: float, now: float | None) -> None:
        """Replaces the goal.

        Args:
            position: (2,) [m].
            stamp: plans for this goal have a later stamp [s].
            now: time from which planner.goal_timeout counts, on the poses' clock [s]; None before the first pose.
        """
        self._since, self._closed_since = now, None
        self._announce(StampedGoal(stamp, position))
        self._log.info(f"goal {position[0]:.3f}, {position[1]:.3f} accepted")

    def refuse(self, stamp: float) -> None:
        """Announces an invalid goal as aborted; the previous goal has ended all the same."""
        self._announce(StampedGoal(stamp, np.full(2, np.nan), GoalStatus.STATUS_ABORTED))

    def set_status(self, status: int) -> None:
        """Sets the status of the newest goal, one of GoalStatus.STATUS_*, and publishes it if it changed."""
        assert self._goal is not None
        if status != self._goal.status:
            self._announce(replace(self._goal, status=status))
            self._log.info(f"goal {self.status_name}")

    def restamp(self, stamp: float) -> None:
        """Gives an active goal a new stamp [s], so that every plan made up to then is refused."""
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
        """Whether the goal was not reached within `timeout` [s] by the poses' clock; a timeout of 0 never passes."""
        if self._since is None:  # accepted before the first pose
            self._since = now
        return bool(timeout) and now is not None and self._since is not None and now - self._since > timeout

    def mark_planned(self) -> None:
        """Notes that a plan leads to the goal."""
        self._closed_since = None
        self.set_status(GoalStatus.STATUS_EXECUTING)

    def is_closed_off(self, local: float) -> bool:
        """Notes that no way leads to the goal at `local` [s, local clock]; whether that has lasted CLOSED_OFF_TIME."""
        if self._closed_since is None:
            self._closed_since = local
        return local - self._closed_since >= CLOSED_OFF_TIME

    def end(self) -> None:
        """Cancels an active goal and waits until listeners have received that."""
        if self._goal is not None and self._goal.active:
            self._goal = replace(self._goal, status=GoalStatus.STATUS_CANCELED)
            publish_acknowledged(self._out, goal_to_status(self._goal))

    def _announce(self, goal: StampedGoal) -> None:
        self._goal = goal
        self._out.publish(goal_to_status(goal))
