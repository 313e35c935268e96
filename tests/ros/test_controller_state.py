"""What the controller is doing, as it goes out: a warning for a stop on the way, once for each change."""

import itertools

from diagnostic_msgs.msg import DiagnosticStatus

from collplan_core.command import FREE_SPACE, MANEUVERS, STOPPED
from collplan_core.control.activity import ACTIVITIES, BOUNCE, TRACK, Activity
from collplan_ros.messages.controller_state import activity_to_message
from collplan_ros.messages.qos import LATCHED
from collplan_ros.nodes.state_output import StateOutput


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


def test_each_change_is_said_once_and_the_last_to_a_late_listener(ros):
    output = StateOutput(ros.probe)
    states = ros.listen(DiagnosticStatus, "controller/state", LATCHED)
    said = ["follows", "follows", "pose 0.17 s old", "pose 0.22 s old", "follows"]
    for words in said:
        output.publish(Activity(TRACK if words == "follows" else STOPPED, words), FREE_SPACE, 1.0, True)
        ros.spin(0.1)
    assert ros.wait_until(lambda: len(states) == 3)
    assert [state.message for state in states] == [said[0], said[2], said[4]]
    late = ros.listen(DiagnosticStatus, "controller/state", LATCHED)
    assert ros.wait_until(lambda: late)
    assert late[0].message == "follows"
