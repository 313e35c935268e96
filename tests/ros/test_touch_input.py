"""What bases tell of a touch becomes an impact, each kind by its own messages."""

import numpy as np
import pytest
from geometry_msgs.msg import Twist, Vector3Stamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import Log
from sensor_msgs.msg import Imu, PointCloud2
from std_msgs.msg import Bool

from collplan_core.state import State
from collplan_ros.messages.cloud_reading import impact_from_cloud
from collplan_ros.messages.conversions import state_to_odometry
from collplan_ros.messages.qos import EVENT, POSE_PUBLISHED
from collplan_ros.node_kit.clock import seconds
from collplan_ros.nodes.base_node import BaseNode
from collplan_ros.nodes.touch_input import why_other_unit, why_unlike_imu


def state_now(ros) -> State:
    return State(seconds(ros.probe.get_clock()), np.array([1.0, 2.0]), np.array([0.8, 0.0]), np.pi / 2)


class TouchBench:
    def __init__(self, ros, kind: str, message_type: type):
        self.ros = ros
        ros.listen(Twist, "/base/cmd_vel")
        self.logged = ros.listen(Log, "/rosout")
        self.impacts = ros.listen(Vector3Stamped, "impact", EVENT)
        self.contacts = ros.listen(PointCloud2, "impact/contact", EVENT)
        self.node = ros.make(BaseNode, {"base.topic": "/base/cmd_vel", "base.touch": kind, "rebound.restitution": 0.5})
        self.poses = ros.publisher(Odometry, "mocap/odom", POSE_PUBLISHED)
        self.touches = ros.publisher(message_type, "/touch", EVENT)

    def says(self, words: str) -> bool:
        return any(words in log.msg for log in self.logged)

    def touch(self, message) -> None:
        for _ in range(5):
            self.poses.publish(state_to_odometry(state_now(self.ros), "map", "base_link", 0.0))
            self.ros.spin(0.02)
        self.touches.publish(message)
        self.ros.spin(0.2)


def spike(x: float, y: float) -> Imu:
    imu = Imu()
    imu.linear_acceleration.x, imu.linear_acceleration.y, imu.linear_acceleration.z = x, y, 9.8
    return imu


@pytest.mark.parametrize(
    ("kind", "quiet", "felt"),
    [("bool", Bool(data=False), Bool(data=True)), ("imu", spike(3.0, 2.0), spike(0.0, 40.0))],
)
def test_a_touch_is_published_once(ros, kind, quiet, felt):
    bench = TouchBench(ros, kind, type(felt))
    bench.touch(quiet)
    assert not bench.impacts
    bench.touch(felt)
    bench.touch(felt)  # goes on
    assert ros.wait_until(lambda: bench.impacts and bench.contacts)
    assert len(bench.impacts) == 1
    # the spike pushes to the left of a robot that faces along y: the obstacle is ahead in the direction of its motion
    np.testing.assert_allclose((bench.impacts[0].vector.x, bench.impacts[0].vector.y), (-1.2, 0.0), atol=1e-9)
    impact = impact_from_cloud(bench.contacts[0], "map")
    np.testing.assert_allclose(impact.normal, (-1.0, 0.0), atol=1e-6)
    assert 1.05 < impact.point[0] < 1.5  # it drives on until the message is taken


def test_what_is_no_number_is_no_impact_and_a_sensor_that_is_otherwise_is_named(ros):
    bench = TouchBench(ros, "imu", Imu)
    for broken in (spike(np.nan, 0.0), spike(0.0, -np.inf)):
        bench.touch(broken)
        bench.touch(spike(0.0, 0.0))
    assert not bench.impacts
    for _ in range(3):  # a sensor turned by 180 degrees: the robot drives into what it feels behind it
        bench.touch(spike(0.0, -40.0))
        bench.touch(spike(0.0, 0.0))
    assert ros.wait_until(lambda: bench.says("3 touches aside of the motion, 0 felt: is the sensor turned?"))


def test_a_contact_that_chatters_is_felt_once_and_named(ros):
    bench = TouchBench(ros, "bool", Bool)
    for _ in range(30):
        bench.touches.publish(Bool(data=True))
        ros.spin(0.01)
        bench.touches.publish(Bool(data=False))
        ros.spin(0.01)
        bench.poses.publish(state_to_odometry(state_now(ros), "map", "base_link", 0.0))
    assert len(bench.impacts) <= 1  # none where it touched before the first pose
    assert ros.wait_until(lambda: bench.says("does the contact chatter?"))


def test_an_imu_is_told_by_its_gravity():
    for rest, said in (
        ((0.1, 0.0, 9.8), ""),
        ((0.0, 0.0, -9.8), "upside down"),
        ((0.0, 9.8, 0.3), "tilted"),
        ((0.0, 0.02, 1.0), "in g?"),
        ((np.nan, 0.0, 9.8), "not finite"),
    ):
        rows = np.tile(rest, (40, 1))
        rows[3] = np.nan, np.inf, 0.0
        rows[7] = 60.0, 0.0, 9.8
        assert said in why_unlike_imu(rows)
        assert bool(why_unlike_imu(rows)) == bool(said)


@pytest.mark.parametrize(
    ("unit", "said"),
    [(1.0, ""), (1 / 9.81, "it reads 0.099 of the accelerations that the poses show, in g?"), (0.0, "0 of")],
)
def test_an_imu_without_gravity_is_told_by_the_velocities(unit, said):
    times = np.arange(300) * 0.01
    speeds = np.column_stack([0.4 * np.sin(3.0 * times), np.minimum(times, 0.5)])
    noise = np.random.default_rng(2).normal(0.0, 0.3, speeds.shape)
    read = unit * (np.gradient(speeds, times, axis=0) + noise + 0.2)  # 0.2: the floor is not level
    rows = np.column_stack([times, read, np.roll(speeds, 3, axis=0)])  # poses come 0.03 s late
    rows[5, 1] = np.inf
    assert said in why_other_unit(rows)
    assert bool(why_other_unit(rows)) == bool(said)
    assert why_other_unit(np.column_stack([times, read, np.full((300, 2), 0.5)])) == ""


def test_a_hit_at_a_side_by_robomasters_own_messages(ros, real_messages):
    kind = real_messages("robomaster_msgs.msg").ArmorHit
    bench = TouchBench(ros, "hit", kind)
    bench.touch(kind(type=kind.IR, location=kind.BOTTOM_RIGHT))
    assert not bench.impacts
    bench.touch(kind(type=kind.COLLISION, location=kind.BOTTOM_RIGHT))
    assert ros.wait_until(lambda: bench.impacts)
    np.testing.assert_allclose((bench.impacts[0].vector.x, bench.impacts[0].vector.y), (-1.2, 0.0), atol=1e-9)
