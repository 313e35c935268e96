"""What becomes of a goal, as planner and controller exchange it."""

import uuid
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from action_msgs.msg import GoalStatus

from collplan_ros.messages.conversions import seconds_from_stamp, stamp_from_seconds

ACTIVE = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING)


@dataclass(frozen=True, eq=False)
class Goal:
    """A goal as the planner took it.

    Attributes:
        stamp: stamp of the newest scan then, on the poses' clock [s]; only plans from later scans are for this goal.
        position: (2,) [m], NaN for one that was refused.
        status: one of GoalStatus.STATUS_*.
        id: 16 bytes, different for every goal.
    """

    stamp: float
    position: np.ndarray
    status: int = GoalStatus.STATUS_ACCEPTED
    id: bytes = field(default_factory=lambda: uuid.uuid4().bytes)

    NAMES: ClassVar[dict[int, str]] = {
        GoalStatus.STATUS_UNKNOWN: "none",
        GoalStatus.STATUS_ACCEPTED: "accepted",
        GoalStatus.STATUS_EXECUTING: "executing",
        GoalStatus.STATUS_SUCCEEDED: "succeeded",
        GoalStatus.STATUS_CANCELED: "canceled",
        GoalStatus.STATUS_ABORTED: "aborted",
    }

    @property
    def active(self) -> bool:
        """Whether the robot is to go there."""
        return self.status in ACTIVE

    @property
    def status_name(self) -> str:
        """The status in a word."""
        return self.NAMES.get(self.status, "unknown")


def goal_to_status(goal: Goal) -> GoalStatus:
    """A goal's identity and status; where it lies stays with the planner."""
    message = GoalStatus(status=goal.status)
    message.goal_info.goal_id.uuid = np.frombuffer(goal.id, dtype=np.uint8)
    message.goal_info.stamp = stamp_from_seconds(goal.stamp)
    return message


def goal_from_status(message: GoalStatus) -> Goal:
    """A goal as others see it; its position is not known."""
    identity = bytes(bytearray(message.goal_info.goal_id.uuid))
    return Goal(seconds_from_stamp(message.goal_info.stamp), np.full(2, np.nan), int(message.status), identity)
