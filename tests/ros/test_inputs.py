"""What a node says at the terminal about the topics it listens to."""

import pytest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import Log
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.node import Node
from ros_fixture import RosGraph
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

from collplan_core.scan import ScanError
from collplan_ros.messages.conversions import MessageError
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT, LATCHED, NEWEST, POSE_SUBSCRIBED, SENSOR_DATA
from collplan_ros.node_kit import input_watch
from collplan_ros.node_kit.inputs import Inputs

INFO, WARN = LoggingSeverity.INFO, LoggingSeverity.WARN


class Listening(Node):
    """Listens to an input of each need; what it is told to refuse, it refuses."""

    def __init__(self, **kwargs):
        super().__init__("listening", **kwargs)
        self.refuse = None
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


class Terminal:
    """What a node writes to the terminal."""

    def __init__(self, ros, node_class=Listening, **kwargs):
        self.ros = ros
        self._logs = ros.listen(Log, "/rosout", DIAGNOSTICS_SUBSCRIBED)
        self.node = ros.make(node_class, **kwargs)

    @property
    def lines(self):
        """Level and text of each line."""
        return [(log.level, log.msg) for log in self._logs if log.name == self.node.get_logger().name]

    def says(self, level, text, timeout=10.0):
        """Waits until it has said this."""
        assert self.ros.wait_until(lambda: (level, text) in self.lines, timeout), f"{text!r} not in {self.lines}"


def steadily(ros, publisher, message, period=0.1):
    return ros.probe.create_timer(period, lambda: publisher.publish(message))


def test_ready_then_what_is_missing_then_what_comes(ros):
    terminal = Terminal(ros)
    terminal.says(INFO, "ready: listens to mocap/odom, scan, state, goal_pose, impact; strategy harness")
    missing = "no mocap/odom: 0 publishers; no scan: 0 publishers; no state: 0 publishers"
    terminal.says(WARN, missing)
    scan = steadily(ros, ros.publisher(LaserScan, "scan", SENSOR_DATA), LaserScan())
    terminal.says(INFO, "scan comes")
    steadily(ros, ros.publisher(Odometry, "mocap/odom", EVENT), Odometry())
    terminal.says(INFO, "mocap/odom comes")
    ros.publisher(String, "state", LATCHED).publish(String())
    terminal.says(INFO, "state comes; waits for goal_pose")
    ros.publisher(PoseStamped, "goal_pose", EVENT).publish(PoseStamped())
    terminal.says(INFO, "goal_pose comes")
    ros.probe.destroy_timer(scan)
    terminal.says(WARN, "no scan: 1 publisher, nothing received")
    assert [text for _, text in terminal.lines].count(missing) == 1
    assert len(terminal.lines) == 7


def test_a_latched_input_is_missed_when_its_node_has_ended(ros):
    terminal = Terminal(ros)
    other = ros.make(lambda **kwargs: Node("other", **kwargs))
    other.create_publisher(String, "state", LATCHED).publish(String())
    assert ros.wait_until(lambda: terminal.node.taken)
    terminal.says(INFO, "state comes")
    ros.remove(other)
    terminal.says(WARN, "no state: 0 publishers")


@pytest.fixture
def other_process():
    """As good as one: a topic has one type in each."""
    graph = RosGraph()
    yield graph
    graph.close()


def test_publishers_that_cannot_be_heard_are_told_with_the_reason(ros, other_process):
    terminal = Terminal(ros)
    other_process.probe.create_publisher(String, "scan", EVENT)
    other_process.probe.create_publisher(String, "state", SENSOR_DATA)
    expected = (
        "no scan: 1 publisher, but of type std_msgs/msg/String, expected sensor_msgs/msg/LaserScan; "
        "no state: 1 publisher, but its QoS does not fit: "
        "best effort publisher and reliable subscription, volatile publisher and transient local subscription"
    )
    assert ros.wait_until(lambda: any(expected in text for _, text in terminal.lines)), terminal.lines


def test_what_is_refused_is_said_to_be_refused_and_counted(ros):
    terminal = Terminal(ros)
    terminal.node.refuse = ScanError("header.frame_id: got 'laser', expected 'base_link'")
    steadily(ros, ros.publisher(LaserScan, "scan", SENSOR_DATA), LaserScan())
    terminal.says(WARN, "scan refused: header.frame_id: got 'laser', expected 'base_link'")
    ros.spin(2.5)
    assert sum("scan" in text for _, text in terminal.lines) == 2  # ready, and once refused
    assert terminal.node.inputs.refusals["scan"] > 10
    terminal.node.refuse = None
    terminal.says(INFO, "scan comes")


def test_a_refusal_is_counted_as_its_kind(ros):
    terminal = Terminal(ros)
    terminal.node.refuse = MessageError("position: not finite")
    odometry = ros.publisher(Odometry, "mocap/odom", EVENT)
    odometry.publish(Odometry())
    refusals = terminal.node.inputs.refusals
    assert ros.wait_until(lambda: refusals["pose"] == 1)
    terminal.node.inputs.refused("mocap/odom", "leaps", "leap")
    assert refusals.values == {"refused_leap": 1, "refused_pose": 1, "last_refusal": "leaps"}
    assert refusals["mocap/odom"] == 0


def test_an_error_of_the_node_itself_is_no_refusal(ros):
    terminal = Terminal(ros)
    terminal.node.refuse = ZeroDivisionError("a bug")
    ros.publisher(LaserScan, "scan", SENSOR_DATA).publish(LaserScan())
    with pytest.raises(ZeroDivisionError):
        ros.wait_until(lambda: False, 10.0)


def test_names_are_those_of_this_graph(ros):
    arguments = ["--ros-args", "-r", "__ns:=/robot1", "-r", "scan:=/front/scan"]
    terminal = Terminal(ros, lambda **kwargs: Listening(cli_args=arguments, **kwargs))
    terminal.says(INFO, "ready: listens to mocap/odom, /front/scan, state, goal_pose, impact; strategy harness")
    ros.probe.create_publisher(LaserScan, "/front/scan", NEWEST)
    assert ros.wait_until(lambda: any("no /front/scan: 1 publisher" in text for _, text in terminal.lines))


def test_a_stalled_node_misses_nothing(ros):
    import time

    terminal = Terminal(ros)
    steadily(ros, ros.publisher(LaserScan, "scan", SENSOR_DATA), LaserScan())
    terminal.says(INFO, "scan comes")
    time.sleep(4.0)
    ros.spin(1.5)
    assert not any(text.startswith("no scan") for _, text in terminal.lines)
