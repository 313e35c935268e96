"""Identity and status of a goal, as planner and controller exchange them on the topic goal_status."""

import uuid
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from action_msgs.msg import GoalStatus

from collplan_ros.messages.conversions import seconds_from_stamp, stamp_from_seconds

ACTIVE = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING)


@dataclass(frozen=True, eq=False)
class StampedGoal:
    """A goal with the stamp from which on plans are made for it.

    Attributes:
        stamp: stamp of the newest pose when the goal was accepted [s]; only plans with a later stamp are for it.
        position: (2,) [m], NaN where it was refused or is not known.
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
        """Whether the robot is to go to it: accepted or executing."""
        return self.status in ACTIVE

    @property
    def status_name(self) -> str:
        """Name of the status."""
        return self.NAMES.get(self.status, "unknown")


def goal_to_status(goal: StampedGoal) -> GoalStatus:
    """Message with a goal's identity, stamp and status; it does not carry the position."""
    message = GoalStatus(status=goal.status)
    message.goal_info.goal_id.uuid = np.frombuffer(goal.id, dtype=np.uint8)
    message.goal_info.stamp = stamp_from_seconds(goal.stamp)
    return message


def goal_from_status(message: GoalStatus) -> StampedGoal:
    """The goal that a message is about, with position NaN."""
    identity = bytes(bytearray(message.goal_info.goal_id.uuid))
    return StampedGoal(seconds_from_stamp(message.goal_info.stamp), np.full(2, np.nan), int(message.status), identity)
