"""What the controller is doing, as it goes out: a warning for a stop on the way."""

import itertools

from diagnostic_msgs.msg import DiagnosticStatus

from collplan_core.command import FREE_SPACE, MANEUVERS, STOPPED
from collplan_core.control.activity import ACTIVITIES, BOUNCE, Activity
from collplan_ros.messages.states import activity_to_message


def test_the_message_says_what_why_and_by_which_plan():
    activity = Activity(BOUNCE, "bounces off the boundary")
    message = activity_to_message(activity, FREE_SPACE, 1.7e9 + 0.25, True, "/puck/controller_node")
    assert (message.name, message.message) == ("/puck/controller_node", activity.reason)
    assert {each.key: each.value for each in message.values} == {
        "maneuver": FREE_SPACE,
        "activity": BOUNCE,
        "reason": activity.reason,
        "plan_stamp": "1700000000.250000000",
    }
    for is_to_move, name, maneuver in itertools.product((False, True), ACTIVITIES, MANEUVERS):
        message = activity_to_message(Activity(name, "why"), maneuver, None, is_to_move, "/controller_node")
        assert (message.level == DiagnosticStatus.WARN) == (is_to_move and name == STOPPED), (name, maneuver)
        assert message.values[-1].value == "none"
