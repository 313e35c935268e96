"""The topic goal_status: a goal's identity, stamp and status, as planner and controller exchange them."""

import numpy as np
from action_msgs.msg import GoalStatus

from collplan_core.goal import NO_GOAL, Goal
from collplan_ros.messages.conversions import stamp_from_seconds
from collplan_ros.messages.reading import GOAL_STATUS, seconds_from_stamp

NUMBERS = {name: number for number, name in GOAL_STATUS.items()}
"""Status as GoalStatus has it, by that of a `Goal`."""


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
    return Goal(identity, stamp, np.full(2, np.nan), GOAL_STATUS.get(int(message.status), NO_GOAL))
