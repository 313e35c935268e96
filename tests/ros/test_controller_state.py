"""What the controller is doing, as it goes out: a warning for a stop on the way, once for each change."""

import itertools

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from collplan_core.command import FREE_SPACE, MANEUVERS, STOPPED
from collplan_core.control.activity import ACTIVITIES, BOUNCE, TRACK, Activity
from collplan_ros.messages.controller_state import activity_to_message
from collplan_ros.messages.qos import LATCHED
from collplan_ros.nodes.state_output import StateOutput


@pytest.mark.parametrize("is_to_move", [False, True])
def test_only_a_stop_of_a_robot_that_is_to_move_is_a_warning(is_to_move):
    for name, maneuver in itertools.product(ACTIVITIES, MANEUVERS):
        message = activity_to_message(Activity(name, "why"), maneuver, 1.0, is_to_move, "/controller_node")
        assert (message.level == DiagnosticStatus.WARN) == (is_to_move and name == STOPPED)


def test_the_message_says_what_why_and_by_which_plan():
    activity = Activity(BOUNCE, "bounces off the boundary at 0.41, 1.20")
    message = activity_to_message(activity, FREE_SPACE, 1.7e9 + 0.25, True, "/puck/controller_node")
    assert (message.name, message.message) == ("/puck/controller_node", activity.reason)
    assert {each.key: each.value for each in message.values} == {
        "maneuver": FREE_SPACE,
        "activity": BOUNCE,
        "reason": activity.reason,
        "plan_stamp": "1700000000.250000000",
    }


def test_without_a_plan_there_is_no_stamp():
    message = activity_to_message(
        Activity(STOPPED, "stands still: no plan yet"), STOPPED, None, True, "/controller_node"
    )
    assert message.values[-1].value == "none"


def test_each_change_is_said_once_and_the_last_to_a_late_listener(ros):
    output = StateOutput(ros.probe)
    states = ros.listen(DiagnosticStatus, "controller/state", LATCHED)
    follows = Activity(TRACK, "follows the plan")
    for activity in (
        follows,
        follows,
        Activity(STOPPED, "stands still: pose 0.17 s old, limit 0.15 s"),
        Activity(STOPPED, "stands still: pose 0.22 s old, limit 0.15 s"),
        follows,
    ):
        before = len(states)
        output.publish(activity, FREE_SPACE, 1.0, True)
        ros.wait_until(lambda before=before: len(states) > before, 0.5)
    assert [state.message for state in states] == [
        "follows the plan",
        "stands still: pose 0.17 s old, limit 0.15 s",
        "follows the plan",
    ]
    late = ros.listen(DiagnosticStatus, "controller/state", LATCHED)
    assert ros.wait_until(lambda: late)
    assert late[0].message == "follows the plan"
