"""inspect --live records what a robot publishes while it is driven by hand, and inspects that."""

import os
import signal
import threading

import rclpy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from collplan_core.parameters import Settings
from collplan_ros.inspect.main import UNREADABLE, main
from collplan_ros.inspect.recording import Topics, read_recording
from collplan_ros.messages.qos import EVENT, SENSOR_DATA


def publish_until_heard(ended: threading.Event, count: int) -> None:
    """Publishes as a robot at rest does; presses Ctrl-C once it has sent so many messages to a listener."""
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("robot", context=context)
    poses = node.create_publisher(Odometry, "odom", EVENT)
    scans = node.create_publisher(LaserScan, "front/scan", SENSOR_DATA)
    while count and not ended.wait(0.02):
        scan = LaserScan(angle_min=-3.0, angle_max=3.0, angle_increment=0.1, range_max=9.0, ranges=[2.0] * 61)
        scan.header.stamp = node.get_clock().now().to_msg()
        poses.publish(Odometry(header=scan.header))
        scans.publish(scan)
        count -= poses.get_subscription_count() > 0 and scans.get_subscription_count() > 0
    if not count:
        os.kill(os.getpid(), signal.SIGINT)
    context.try_shutdown()


def test_ctrl_c_ends_listening_and_what_came_is_inspected_where_nothing_came_nothing_is_left(tmp_path, capsys):
    assert main(["--live", "0.3", "--out", str(tmp_path)]) == UNREADABLE
    assert "no topic" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
    ended = threading.Event()
    robot = threading.Thread(target=publish_until_heard, args=(ended, 60))
    robot.start()
    try:
        assert main(["--live", "60", "--out", str(tmp_path)]) != UNREADABLE
    finally:
        ended.set()
        robot.join()
    (path,) = tmp_path.glob("*.mcap")
    found = read_recording(path, Topics(), Settings().mocap, lambda _: None)
    assert (found.topics, found.is_cut) == (Topics("/odom", "/front/scan"), False)
    assert min(len(found.poses), len(found.scans)) > 30
    assert {"found.yaml", "inspect.json", "inspect.html"} <= {each.name for each in tmp_path.iterdir()}
