"""mocap_node alone, with a fake motion capture."""

import math

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from std_msgs.msg import String

from collplan_core.parameters.spec import ParameterError
from collplan_core.sensing.pose_filter import PoseSample
from collplan_ros.messages.conversions import (
    impact_contact_from_message,
    pose_to_message,
    seconds_from_stamp,
    state_from_odometry,
)
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT, POSE_PUBLISHED, POSE_SUBSCRIBED
from collplan_ros.nodes.mocap_node import MocapNode

CREEP = (1e-3, 0.0)
"""Velocity almost at rest, at which no pose repeats the last one [m/s]."""


class MocapBench:
    """The node, a motion capture that feeds it, and everything it says."""

    def __init__(self, ros, parameters=None):
        self.ros = ros
        self.odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
        self.refusals = ros.listen(String, "mocap/refused", POSE_SUBSCRIBED)
        self.impacts = ros.listen(Vector3Stamped, "impact", EVENT)
        self.contacts = ros.listen(PoseStamped, "impact/contact", EVENT)
        self.reports = ros.listen(DiagnosticArray, "/diagnostics", DIAGNOSTICS_SUBSCRIBED)
        self.node = ros.make(MocapNode, parameters)
        self.poses = ros.publisher(PoseStamped, "mocap/pose", POSE_PUBLISHED)
        assert ros.wait_until(lambda: self.node.count_subscribers("mocap/odom") and self.reports)
        self.sent = 0

    def send(self, message):
        """One pose, taken by the node before this returns."""
        self.poses.publish(message)
        self.sent += 1
        assert self.ros.wait_until(lambda: self.node._counts["received"] == self.sent)

    def send_at(self, stamp, x, y):
        self.send(pose_to_message(PoseSample(stamp, np.array([x, y]), 0.3), "map"))

    def drive(self, begin, n, start, velocity):
        """n poses at 100 Hz along a straight line."""
        for k in range(n):
            self.send_at(begin + 0.01 * k, *(np.array(start) + 0.01 * k * np.array(velocity)))

    def values(self):
        return {value.key: value.value for value in self.reports[-1].status[0].values}


@pytest.fixture
def bench(ros):
    return MocapBench(ros)


def test_poses_become_odometry(ros, bench):
    bench.drive(5.0, 20, (0.5, 1.0), (0.8, -0.4))
    assert ros.wait_until(lambda: len(bench.odometry) >= 14)
    state = state_from_odometry(bench.odometry[-1], "map", "base_link")
    np.testing.assert_allclose(state.position, [0.652, 0.924], atol=1e-9)
    np.testing.assert_allclose(state.velocity, [0.8, -0.4], atol=1e-6)
    assert state.yaw == pytest.approx(0.3)
    assert state.stamp == pytest.approx(5.19, abs=1e-9)
    assert not bench.impacts


def test_hit_is_published_once(ros, bench):
    bench.drive(5.0, 25, (0.0, 0.0), (1.0, 0.2))
    bench.drive(5.25, 25, (0.25, 0.05), (-0.7, 0.2))
    assert ros.wait_until(lambda: bench.impacts)
    ros.spin(0.05)
    assert len(bench.impacts) == 1
    change = bench.impacts[0]
    assert change.header.frame_id == "map"
    assert (change.vector.x, change.vector.y) == pytest.approx((-1.7, 0.0), abs=0.1)
    assert ros.wait_until(lambda: bench.contacts)
    assert len(bench.contacts) == 1
    contact = impact_contact_from_message(bench.contacts[0], "map")
    assert contact.time == pytest.approx(5.25, abs=0.002)
    assert contact.time < seconds_from_stamp(change.header.stamp) - 0.005
    np.testing.assert_allclose(contact.point, [0.34, 0.05], atol=0.005)
    np.testing.assert_allclose(contact.normal, [-1.0, 0.0], atol=0.05)


def broken(**fields):
    message = pose_to_message(PoseSample(5.3, np.array([0.1, 0.1]), 0.0), "map")
    for path, value in fields.items():
        target = message
        *inner, last = path.split("__")
        for name in inner:
            target = getattr(target, name)
        setattr(target, last, value)
    return message


BROKEN = {
    "nan": ("not_finite", broken(pose__position__x=math.nan)),
    "infinite": ("not_finite", broken(pose__position__y=math.inf)),
    "nan_quaternion": ("not_finite", broken(pose__orientation__w=math.nan)),
    "zeros": (
        "zeros",
        broken(pose__position__x=0.0, pose__position__y=0.0, pose__orientation__w=0.0, pose__orientation__z=0.0),
    ),
    "quaternion": ("quaternion", broken(pose__orientation__w=0.5)),
    "no_quaternion": ("quaternion", broken(pose__orientation__w=0.0)),
    "frame": ("frame", broken(header__frame_id="odom")),
    "leap": ("leap", broken(pose__position__x=3.0)),
    "turned": ("yaw", broken(pose__orientation__z=1.0, pose__orientation__w=0.0)),
    "tipped": ("tilt", broken(pose__orientation__x=math.sin(0.2), pose__orientation__w=math.cos(0.2))),
    "lifted": ("height", broken(pose__position__z=0.2)),
}


@pytest.mark.parametrize("kind", BROKEN)
def test_what_is_no_pose_goes_nowhere(ros, bench, kind):
    reason, message = BROKEN[kind]
    bench.drive(5.0, 10, (0.1, 0.1), CREEP)
    assert ros.wait_until(lambda: len(bench.odometry) == 4)
    bench.send(message)
    ros.spin(0.05)
    assert len(bench.odometry) == 4
    bench.node._diagnostics.publish()
    assert ros.wait_until(lambda: bench.values().get(f"refused_{reason}") == "1")
    assert reason in bench.reports[-1].status[0].message
    assert ros.wait_until(lambda: bench.refusals)
    assert [message.data.split(":")[0] for message in bench.refusals] == [reason]


def test_where_the_markers_sit_cannot_be_changed_live(bench):
    for key in ("x", "y", "yaw"):
        (result,) = bench.node.set_parameters([Parameter(f"mocap.body_offset_{key}", value=0.5)])
        assert not result.successful


def test_stamp_that_does_not_rise_goes_nowhere(ros, bench):
    bench.drive(5.0, 10, (0.1, 0.1), CREEP)
    bench.send_at(5.05, 0.1, 0.1)
    bench.send_at(5.09, 0.2, 0.1)
    bench.node._diagnostics.publish()
    assert ros.wait_until(lambda: bench.values().get("refused_stamp") == "2")


def test_relocation_is_accepted_in_the_end(ros):
    bench = MocapBench(ros, {"mocap.relocation_time": 0.1})
    bench.drive(5.0, 10, (0.1, 0.1), CREEP)
    bench.drive(5.1, 13, (2.0, 1.0), CREEP)
    assert ros.wait_until(lambda: bench.odometry and bench.odometry[-1].pose.pose.position.x > 1.9)
    assert ros.wait_until(lambda: bench.refusals and bench.refusals[-1].data.startswith("carried: pose 2.000, 1"))
    assert {message.data.split(":")[0] for message in bench.refusals[:-1]} == {"leap"}
    bench.node._diagnostics.publish()
    assert ros.wait_until(lambda: bench.values().get("relocations") == "1")


def test_silence_is_reported(ros, bench):
    status = bench.reports[0].status[0]
    assert status.name == "/mocap_node"
    assert status.level == b"\x02"
    assert "no pose" in status.message
    assert "/mocap/pose" in status.message


def test_poses_that_come_too_far_apart_are_named(ros, bench):
    def says(what):
        bench.node._diagnostics.publish()
        ros.spin(0.01)
        return what in bench.reports[-1].status[0].message

    stamps = (5.0 + 0.2 * k for k in range(100))
    expected = "poses come 0.20 s apart, expected less than limits.pose_age 0.15 s"
    assert ros.wait_until(lambda: bench.send_at((stamp := next(stamps)), 1e-4 * stamp, 0.1) or says(expected))
    assert not bench.odometry
    bench.drive(100.0, 10, (0.1, 0.1), CREEP)
    assert ros.wait_until(lambda: bench.odometry)
    assert ros.wait_until(lambda: not says("apart"))


def test_frames_are_parameters(ros):
    bench = MocapBench(ros, {"frames.map": "lab", "frames.base": "puck", "mocap.accept_frozen": True})
    for k in range(10):
        bench.send(pose_to_message(PoseSample(1.0 + 0.01 * k, np.zeros(2), 0.0), "lab"))
    assert ros.wait_until(lambda: bench.odometry)
    assert (bench.odometry[0].header.frame_id, bench.odometry[0].child_frame_id) == ("lab", "puck")


def test_transform_without_tf2_is_an_error_that_says_so(ros):
    try:
        import tf2_ros  # noqa: F401
    except ImportError:
        with pytest.raises(ParameterError, match=r"mocap\.publish_tf.*tf2_ros"):
            ros.make(MocapNode, {"mocap.publish_tf": True})
    else:
        pytest.skip("tf2_ros is installed here")
