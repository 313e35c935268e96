"""inspect --live records what a robot publishes while it is driven by hand, and inspects that."""

import os
import signal
import threading

import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from collplan_core.parameters import Settings
from collplan_ros.inspect.main import UNREADABLE, main
from collplan_ros.inspect.recording import Topics, read_recording
from collplan_ros.messages.qos import EVENT, SENSOR_DATA

POSES = 60


def drive(ended: threading.Event) -> None:
    """Publishes as a robot at rest does, until Ctrl-C once enough poses have found a listener."""
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("robot", context=context)
    scans = node.create_publisher(LaserScan, "front/scan", SENSOR_DATA)
    publishers = [node.create_publisher(Odometry, "odom", EVENT), scans, node.create_publisher(Twist, "cmd_vel", EVENT)]
    sent = 0
    while not ended.wait(0.02) and sent < POSES:
        now = node.get_clock().now().to_msg()
        scan = LaserScan(angle_min=-3.0, angle_max=3.0, angle_increment=0.1, range_max=9.0, ranges=[2.0] * 61)
        odometry = Odometry()
        odometry.pose.pose.orientation.w = 1.0
        scan.header.stamp = odometry.header.stamp = now
        for publisher, message in zip(publishers, (odometry, scan, Twist()), strict=True):
            publisher.publish(message)
        sent += all(publisher.get_subscription_count() for publisher in publishers)
    if not ended.is_set():
        os.kill(os.getpid(), signal.SIGINT)
    node.destroy_node()
    context.try_shutdown()


def test_ctrl_c_ends_listening_and_what_came_is_inspected(tmp_path):
    ended = threading.Event()
    robot = threading.Thread(target=drive, args=(ended,))
    robot.start()
    try:
        assert main(["--live", "60", "--out", str(tmp_path)]) in (0, 1)
    finally:
        ended.set()
        robot.join()
    (path,) = tmp_path.glob("*.mcap")
    found = read_recording(path, Topics(), Settings().mocap, lambda _: None)
    assert found.topics == Topics("/odom", "/front/scan", "/cmd_vel")
    assert not found.is_cut
    assert min(len(found.poses), len(found.scans), len(found.commands)) >= POSES // 2
    assert {"found.yaml", "inspect.json", "inspect.html"} <= {each.name for each in tmp_path.iterdir()}


def test_where_nothing_comes_nothing_is_left(tmp_path, capsys):
    assert main(["--live", "0.3", "--out", str(tmp_path)]) == UNREADABLE
    assert "no message" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
