"""What a node says at the terminal about the topics it listens to."""

import pytest
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from ros_fixture import RosGraph
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan, PointCloud2
from std_msgs.msg import String
from terminal import INFO, WARN, Terminal

from collplan_core.scan import ScanError
from collplan_ros.messages.qos import EVENT, LATCHED, POSE_SUBSCRIBED, SENSOR_DATA
from collplan_ros.messages.reading import MessageError
from collplan_ros.node_kit.inputs import EVENT as EVENT_INPUT
from collplan_ros.node_kit.inputs import STATE, Inputs, type_name
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from collplan_ros.nodes.planner_node import PlannerNode
from omnipuck_sim.node.simulator_node import SimulatorNode


class Listening(Node):
    def __init__(self, **kwargs):
        super().__init__("listening", **kwargs)
        self.refuse = None
        self.taken = 0
        self.is_ours = None
        self.inputs = Inputs(self)
        self.inputs.listen(Odometry, "mocap/odom", self.take, POSE_SUBSCRIBED, kind="pose")
        self.inputs.listen(LaserScan, "scan", self.take, SENSOR_DATA)
        self.inputs.listen(String, "state", self.take, LATCHED, STATE)
        self.inputs.listen(PoseStamped, "goal_pose", self.take, EVENT, EVENT_INPUT)
        self.inputs.ready("strategy harness")

    def take(self, message):
        self.taken += 1
        if self.refuse is not None:
            raise self.refuse
        return self.is_ours


@pytest.fixture
def terminal(ros):
    return Terminal(ros)


@pytest.fixture
def node(ros, terminal):
    return ros.make(Listening)


def steadily(ros, publisher, message):
    return ros.probe.create_timer(0.1, lambda: publisher.publish(message))


def test_ready_then_what_is_missing_then_what_comes_each_once(ros, terminal, node):
    terminal.says(node, INFO, "ready: listens to mocap/odom, scan, state, goal_pose; strategy harness")
    terminal.says(node, WARN, "no mocap/odom: 0 publishers; no scan: 0 publishers; no state: 0 publishers")
    scan = steadily(ros, ros.publisher(LaserScan, "scan", SENSOR_DATA), LaserScan())
    terminal.says(node, INFO, "scan comes")
    steadily(ros, ros.publisher(Odometry, "mocap/odom", EVENT), Odometry())
    other = ros.make(lambda **kwargs: Node("other", **kwargs))
    other.create_publisher(String, "state", LATCHED).publish(String())
    assert terminal.has(node, "state com")
    ros.probe.destroy_timer(scan)
    assert terminal.has(node, "no scan: 1 publisher")
    ros.remove(other)
    assert terminal.has(node, "no state: 0 publishers", 2)
    assert len(terminal.lines(node)) <= 8


@pytest.fixture
def other_process():
    graph = RosGraph()
    yield graph
    graph.close()


def test_a_publisher_that_cannot_be_heard_is_told_with_the_reason(terminal, node, other_process):
    other_process.probe.create_publisher(String, "state", SENSOR_DATA)
    assert terminal.has(node, "on topic 'state', offering incompatible QoS")


WRONG_TYPES = (
    (ControllerNode, "hand/cmd_vel", TwistStamped, "geometry_msgs/msg/Twist"),
    (SimulatorNode, "goal_status", String, "action_msgs/msg/GoalStatus"),
    (PlannerNode, "scan", PointCloud2, "sensor_msgs/msg/LaserScan"),
    (MocapNode, "mocap/pose", PoseWithCovarianceStamped, "geometry_msgs/msg/PoseStamped"),
    (LidarNode, "mocap/odom", PoseStamped, "nav_msgs/msg/Odometry"),
)


def test_every_node_names_messages_of_another_type(ros, terminal, other_process):
    for node_class, topic, sent, expected in WRONG_TYPES:
        node, other = ros.make(node_class), other_process.probe.create_publisher(sent, topic, EVENT)
        words = f"{topic}: 1 publisher, but of type {type_name(sent)}, expected {expected}"
        assert terminal.has(node, words), terminal.lines(node)
        if sent is TwistStamped:
            assert terminal.has(node, "(controller.stamped_cmd_vel)")
        ros.remove(node)
        other_process.probe.destroy_publisher(other)


@pytest.mark.parametrize("has_clock", [False, True])
def test_a_node_on_simulated_time_without_a_clock_says_so(ros, terminal, has_clock):
    node = ros.make(Listening, {"use_sim_time": True})
    if has_clock:  # one that stands at 0
        steadily(ros, ros.publisher(Clock, "/clock", SENSOR_DATA), Clock())
    topics = {"scan": LaserScan, "mocap/odom": Odometry, "goal_pose": PoseStamped}
    for topic, sent in topics.items():
        steadily(ros, ros.publisher(sent, topic, SENSOR_DATA if sent is LaserScan else EVENT), sent())
    found = "1 publisher, nothing received later than 0 s" if has_clock else "0 publishers"
    for topic in topics:
        assert terminal.has(node, f"{topic}: 1 publisher, but no /clock: {found}, and use_sim_time is true")


def test_what_is_refused_or_not_for_this_node_is_said_once_and_counted_as_its_kind(ros, terminal, node):
    node.refuse = ScanError("frame")
    steadily(ros, ros.publisher(LaserScan, "scan", SENSOR_DATA), LaserScan())
    terminal.says(node, WARN, "scan refused: frame")
    assert ros.wait_until(lambda: node.inputs.refusals["scan"] > 10)
    node.refuse = MessageError("not finite")
    ros.publisher(Odometry, "mocap/odom", EVENT).publish(Odometry())
    assert ros.wait_until(lambda: node.inputs.refusals["pose"] == 1)
    assert node.inputs.refusals["mocap/odom"] == 0
    node.refuse, node.is_ours = None, False
    assert terminal.has(node, "its messages hold nothing for this node")
    node.is_ours = True
    terminal.says(node, INFO, "scan comes")
    assert [text for _, text in terminal.lines(node)].count("scan refused: frame") == 1


def test_an_error_of_the_node_itself_is_no_refusal(ros, node):
    node.refuse = ZeroDivisionError("a bug")
    ros.publisher(LaserScan, "scan", SENSOR_DATA).publish(LaserScan())
    with pytest.raises(ZeroDivisionError):
        ros.wait_until(lambda: False, 10.0)
