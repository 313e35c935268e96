"""The topics goal_status, robot/state and controller/: state, drive. What planner, controller and robot are about."""

from collections.abc import Mapping

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from collplan_core.command import HAND, STANDING, Command
from collplan_core.goal import NO_GOAL, Goal
from collplan_core.learning.drive import Drive, LearntDrive
from collplan_ros.messages.conversions import stamp_from_seconds
from collplan_ros.messages.reading import GOAL_STATUS, seconds_from_stamp
from collplan_ros.messages.status_values import DRIVE

FREE, HELD, STOPPED = "free", "held", "stopped"
"""It follows commands; it waits for a person; its emergency stop is latched."""
NOT_LEARNT = "its drive is not learnt yet: too little driving that follows the commands"

NUMBERS = {name: number for number, name in GOAL_STATUS.items()}
"""Status as GoalStatus has it, by that of a `Goal`."""


def status_message(name: str, level: bytes, message: str, values: Mapping[str, object]) -> DiagnosticStatus:
    """Message of a node's status, by its full name, with floats printed to six digits."""
    pairs = [KeyValue(key=str(key), value=_shown(value)) for key, value in values.items()]
    return DiagnosticStatus(level=level, name=str(name), message=message, values=pairs)


def _shown(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


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


def command_in_words(command: Command, slowed: str = "") -> str:
    """What the robot does at a command, in words; `slowed` is the reason why a hand drives it slowly, or empty."""
    doing, slowed = command.maneuver.replace("_", " "), slowed or command.reason
    if command.maneuver in STANDING:
        return f"stands still: {command.reason}"
    if command.maneuver == HAND:
        doing = "driven by hand"
    return f"{doing}, slowly: {slowed}" if slowed else doing


def command_to_state(
    command: Command, reason: str, plan_stamp: float | None, is_to_move: bool, source: str
) -> DiagnosticStatus:
    """Message of what the controller does; a warning where the robot stands still although it is to move.

    `reason` is what the command does, in words; `plan_stamp` that of the plan in force [s, poses' clock]. The robot
    `is_to_move` to a goal, or where a hand drives it. `source` is the full name of the controller's node.
    """
    values = {
        "maneuver": command.maneuver,
        "reason": reason,
        "plan_stamp": "none" if plan_stamp is None else _printed(plan_stamp),
    }
    warns = is_to_move and command.maneuver in STANDING
    return status_message(source, DiagnosticStatus.WARN if warns else DiagnosticStatus.OK, reason, values)


def drive_to_message(
    in_use: Drive, learnt: LearntDrive | None, belief: Drive, source: str, shown: str = ""
) -> DiagnosticStatus:
    """Message of the drive in use and what was learnt of it; a warning where it is not what is set, beyond doubt.

    `shown` is what motion shows of the base; or empty.
    """
    unlike = "; ".join(filter(None, [shown, "" if learnt is None else learnt.why_unlike(belief)]))
    values = dict[str, float](zip(DRIVE, in_use, strict=True))
    for name, known in () if learnt is None else zip(DRIVE, learnt, strict=True):
        values |= {f"{name}.learnt": known.value, f"{name}.low": known.low, f"{name}.high": known.high}
    level, told = (
        DiagnosticStatus.WARN if unlike else DiagnosticStatus.OK,
        NOT_LEARNT if learnt is None else str(learnt),
    )
    return status_message(source, level, unlike or told, {key: repr(float(value)) for key, value in values.items()})


def _printed(seconds: float) -> str:
    """A stamp [s] with its nanoseconds, as in the header of the plan."""
    stamp = stamp_from_seconds(seconds)
    return f"{stamp.sec}.{stamp.nanosec:09d}"
