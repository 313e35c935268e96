"""Message of the controller's activity and its reason, for people and records."""

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from collplan_core.command import STOPPED
from collplan_core.control.activity import Activity
from collplan_ros.messages.conversions import stamp_from_seconds


def activity_to_message(
    activity: Activity, maneuver: str, plan_stamp: float | None, is_to_move: bool, source: str
) -> DiagnosticStatus:
    """Message of an activity; a warning where the robot stands still although it is to move.

    Args:
        activity: activity of the controller.
        maneuver: maneuver of its command, one of `collplan_core.command.MANEUVERS`.
        plan_stamp: stamp of the plan in force [s, poses' clock]; None without one.
        is_to_move: whether the robot is to go to a goal, or where a hand drives it.
        source: full name of the controller's node.
    """
    values = {
        "maneuver": maneuver,
        "activity": activity.name,
        "reason": activity.reason,
        "plan_stamp": "none" if plan_stamp is None else _printed(plan_stamp),
    }
    return DiagnosticStatus(
        level=DiagnosticStatus.WARN if is_to_move and activity.name == STOPPED else DiagnosticStatus.OK,
        name=str(source),
        message=activity.reason,
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )


def _printed(seconds: float) -> str:
    """A stamp [s] with its nanoseconds, as in the header of the plan."""
    stamp = stamp_from_seconds(seconds)
    return f"{stamp.sec}.{stamp.nanosec:09d}"
