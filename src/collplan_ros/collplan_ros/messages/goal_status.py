"""The topic goal_status: a goal's identity, stamp and status, as planner and controller exchange them."""

import numpy as np
from action_msgs.msg import GoalStatus

from collplan_core.goal import ABORTED, ACCEPTED, CANCELED, EXECUTING, NO_GOAL, SUCCEEDED, Goal
from collplan_ros.messages.conversions import seconds_from_stamp, stamp_from_seconds

NUMBERS = {
    NO_GOAL: GoalStatus.STATUS_UNKNOWN,
    ACCEPTED: GoalStatus.STATUS_ACCEPTED,
    EXECUTING: GoalStatus.STATUS_EXECUTING,
    SUCCEEDED: GoalStatus.STATUS_SUCCEEDED,
    CANCELED: GoalStatus.STATUS_CANCELED,
    ABORTED: GoalStatus.STATUS_ABORTED,
}
"""Status as GoalStatus has it, by that of a `Goal`."""
NAMES = {number: name for name, number in NUMBERS.items()}


def goal_to_status(goal: Goal) -> GoalStatus:
    """Message with a goal's identity, stamp and status; it does not carry the position."""
    message = GoalStatus(status=NUMBERS[goal.status])
    message.goal_info.goal_id.uuid = np.frombuffer(goal.id, dtype=np.uint8)
    message.goal_info.stamp = stamp_from_seconds(goal.stamp)
    return message


def goal_from_status(message: GoalStatus) -> Goal:
    """The goal that a message is about, with position NaN; a status that no goal here has counts as no goal."""
    identity = bytes(bytearray(message.goal_info.goal_id.uuid))
    stamp = seconds_from_stamp(message.goal_info.stamp)
    return Goal(identity, stamp, np.full(2, np.nan), NAMES.get(int(message.status), NO_GOAL))
