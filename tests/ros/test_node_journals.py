"""The journals of the nodes: what comes by a message, a parameter or a service is in them, and they are replayed."""

from geometry_msgs.msg import PoseStamped, Twist
from rclpy.parameter import Parameter
from std_msgs.msg import Empty, String
from std_srvs.srv import Trigger

from collplan_core.replay.comparison import compare
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.replay.reading import Call, Event, events_of, rows_of
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.qos import EVENT, JOURNAL, NEWEST
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.planner_node import PlannerNode
from fake_robot import GOAL, FakeRobot, hall

BROUGHT = {
    PLANNER: {"change_settings", "refuse", "refuse_goal", "take_goal", "cancel", "forget_scans", "take_manual_command"},
    CONTROLLER: {"change_settings", "refuse", "resume", "take_goal", "take_plan", "take_manual_command"},
}


def test_what_a_message_brings_is_in_the_journal_which_a_late_recorder_hears_from_its_beginning(ros):
    robot = FakeRobot(ros, hall())
    planner = ros.make(PlannerNode, {"planner.map_period": 0.1})
    # all share a thread here, and poses wait in its queues
    controller = ros.make(ControllerNode, {"limits.motion_delay": 0.4})
    goals, hand = (
        ros.publisher(PoseStamped, "goal_pose", EVENT),
        ros.publisher(Twist, "hand/cmd_vel", NEWEST, matched=2),
    )
    assert ros.wait_until(robot.is_heard)
    robot.scans.publish(robot.bad_scans()[0])
    goals.publish(goal_to_message(GOAL, "moon"))
    goals.publish(goal_to_message(GOAL, "map"))
    heard = {of: ros.listen(String, f"{of}/journal", JOURNAL) for of in BROUGHT}

    def called(of) -> set[str]:
        return {event.name for event in events(of, heard[of]) if isinstance(event, Call)}

    assert ros.wait_until(lambda: "take_plan" in called(CONTROLLER))
    for node, key in ((planner, "planner.turn_penalty"), (controller, "controller.k_p")):
        assert node.set_parameters([Parameter(key, value=3.0)])[0].successful
    assert ros.call(Trigger, "cancel").success
    ros.publisher(Empty, "robot/resumed", EVENT, matched=2).publish(Empty())
    assert ros.wait_until(lambda: hand.publish(Twist()) or all(called(of) >= names for of, names in BROUGHT.items()))
    for of, messages in heard.items():
        (comparison,) = compare(of, events(of, messages))
        assert comparison.end is None, comparison.end
        assert comparison.calls > 20
        assert '"number":0,' in messages[0].data


def events(of, messages) -> list[Event]:
    return list(events_of(rows_of((message.data for message in messages), ""), of))
