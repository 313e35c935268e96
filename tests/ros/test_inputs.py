"""What a node says at the terminal about the topics it listens to."""

import time

import pytest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from ros_fixture import RosGraph
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String
from terminal import INFO, WARN, Terminal

from collplan_core.scan import ScanError
from collplan_ros.messages.conversions import MessageError
from collplan_ros.messages.qos import EVENT, LATCHED, NEWEST, POSE_SUBSCRIBED, SENSOR_DATA
from collplan_ros.node_kit import input_watch
from collplan_ros.node_kit.inputs import Inputs


class Listening(Node):
    """Listens to an input of each need; what it is told to refuse, it refuses."""

    def __init__(self, **kwargs):
        super().__init__("listening", **kwargs)
        self.refuse = None
        self.is_ours = None
        self.taken = []
        self.inputs = Inputs(self)
        self.inputs.listen(Odometry, "mocap/odom", self.take, POSE_SUBSCRIBED, kind="pose")
        self.inputs.listen(LaserScan, "scan", self.take, SENSOR_DATA)
        self.inputs.listen(String, "state", self.take, LATCHED, input_watch.STATE)
        self.inputs.listen(PoseStamped, "goal_pose", self.take, EVENT, input_watch.AWAITED)
        self.inputs.listen(String, "impact", self.take, EVENT, input_watch.EVENT)
        self.inputs.ready("strategy harness")

    def take(self, message):
        if self.refuse is not None:
            raise self.refuse
        self.taken.append(message)
        return self.is_ours


@pytest.fixture
def terminal(ros):
    return Terminal(ros)


@pytest.fixture
def node(ros, terminal):
    return ros.make(Listening)


def steadily(ros, publisher, message, period=0.1):
    return ros.probe.create_timer(period, lambda: publisher.publish(message))


def test_ready_then_what_is_missing_then_what_comes(ros, terminal, node):
    terminal.says(node, INFO, "ready: listens to mocap/odom, scan, state, goal_pose, impact; strategy harness")
    missing = "no mocap/odom: 0 publishers; no scan: 0 publishers; no state: 0 publishers"
    terminal.says(node, WARN, missing)
    scan = steadily(ros, ros.publisher(LaserScan, "scan", SENSOR_DATA), LaserScan())
    terminal.says(node, INFO, "scan comes")
    steadily(ros, ros.publisher(Odometry, "mocap/odom", EVENT), Odometry())
    terminal.says(node, INFO, "mocap/odom comes")
    ros.publisher(String, "state", LATCHED).publish(String())
    terminal.says(node, INFO, "state comes; waits for goal_pose")
    ros.publisher(PoseStamped, "goal_pose", EVENT).publish(PoseStamped())
    terminal.says(node, INFO, "goal_pose comes")
    ros.probe.destroy_timer(scan)
    terminal.says(node, WARN, "no scan: 1 publisher, nothing received")
    assert [text for _, text in terminal.lines(node)].count(missing) == 1
    assert len(terminal.lines(node)) == 7


def test_a_latched_input_is_missed_when_its_node_has_ended(ros, terminal, node):
    other = ros.make(lambda **kwargs: Node("other", **kwargs))
    other.create_publisher(String, "state", LATCHED).publish(String())
    assert ros.wait_until(lambda: node.taken)
    terminal.says(node, INFO, "state comes")
    ros.remove(other)
    terminal.says(node, WARN, "no state: 0 publishers")


@pytest.fixture
def other_process():
    """As good as one: a topic has one type in each."""
    graph = RosGraph()
    yield graph
    graph.close()


def test_publishers_that_cannot_be_heard_are_told_with_the_reason(ros, terminal, node, other_process):
    other_process.probe.create_publisher(String, "scan", EVENT)
    other_process.probe.create_publisher(String, "state", SENSOR_DATA)
    expected = (
        "no scan: 1 publisher, but of type std_msgs/msg/String, expected sensor_msgs/msg/LaserScan; "
        "no state: 1 publisher, but its QoS does not fit: "
        "best effort publisher and reliable subscription, volatile publisher and transient local subscription"
    )
    assert ros.wait_until(lambda: any(expected in text for _, text in terminal.lines(node))), terminal.lines(node)


def test_what_is_refused_is_said_to_be_refused_and_counted(ros, terminal, node):
    node.refuse = ScanError("header.frame_id: got 'laser', expected 'base_link'")
    steadily(ros, ros.publisher(LaserScan, "scan", SENSOR_DATA), LaserScan())
    terminal.says(node, WARN, "scan refused: header.frame_id: got 'laser', expected 'base_link'")
    ros.spin(2.5)
    assert sum("scan" in text for _, text in terminal.lines(node)) == 2  # ready, and once refused
    assert node.inputs.refusals["scan"] > 10
    node.refuse = None
    terminal.says(node, INFO, "scan comes")


def test_a_refusal_is_counted_as_its_kind(ros, node):
    node.refuse = MessageError("position: not finite")
    odometry = ros.publisher(Odometry, "mocap/odom", EVENT)
    odometry.publish(Odometry())
    refusals = node.inputs.refusals
    assert ros.wait_until(lambda: refusals["pose"] == 1)
    node.inputs.refused("mocap/odom", "leaps", "leap")
    assert refusals.values == {"refused_leap": 1, "refused_pose": 1, "last_refusal": "leaps"}
    assert refusals["mocap/odom"] == 0


def test_messages_that_are_not_for_this_node_are_no_input(ros, terminal, node):
    node.is_ours = False
    steadily(ros, ros.publisher(LaserScan, "scan", SENSOR_DATA), LaserScan())
    said = "no scan: 1 publisher, but its messages hold nothing for this node"
    assert ros.wait_until(lambda: any(said in text for _, text in terminal.lines(node)))
    node.is_ours = True
    terminal.says(node, INFO, "scan comes")
    assert node.inputs.refusals.values == {}


def test_an_error_of_the_node_itself_is_no_refusal(ros, node):
    node.refuse = ZeroDivisionError("a bug")
    ros.publisher(LaserScan, "scan", SENSOR_DATA).publish(LaserScan())
    with pytest.raises(ZeroDivisionError):
        ros.wait_until(lambda: False, 10.0)


def test_names_are_those_of_this_graph(ros, terminal):
    arguments = ["--ros-args", "-r", "__ns:=/robot1", "-r", "scan:=/front/scan"]
    node = ros.make(lambda **kwargs: Listening(cli_args=arguments, **kwargs))
    terminal.says(node, INFO, "ready: listens to mocap/odom, /front/scan, state, goal_pose, impact; strategy harness")
    ros.probe.create_publisher(LaserScan, "/front/scan", NEWEST)
    assert ros.wait_until(lambda: any("no /front/scan: 1 publisher" in text for _, text in terminal.lines(node)))


def test_a_stalled_node_misses_nothing(ros, terminal, node):
    steadily(ros, ros.publisher(LaserScan, "scan", SENSOR_DATA), LaserScan())
    terminal.says(node, INFO, "scan comes")
    time.sleep(4.0)
    ros.spin(1.5)
    assert not any(text.startswith("no scan") for _, text in terminal.lines(node))
