"""What bases tell of a touch becomes an impact, each kind by its own messages."""

import numpy as np
import pytest
from geometry_msgs.msg import Twist, Vector3Stamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, PointCloud2
from std_msgs.msg import Bool

from collplan_core.parameters.spec import ParameterError
from collplan_core.state import State
from collplan_ros.messages.cloud_reading import impact_from_cloud
from collplan_ros.messages.conversions import state_to_odometry
from collplan_ros.messages.qos import EVENT, POSE_PUBLISHED
from collplan_ros.node_kit.clock import seconds
from collplan_ros.nodes.base_node import BaseNode


class TouchBench:
    """base_node, a robot that drives along x and faces along y, and the impacts heard."""

    def __init__(self, ros, kind: str, message_type: type):
        self.ros = ros
        ros.listen(Twist, "/base/cmd_vel")
        self.impacts = ros.listen(Vector3Stamped, "impact", EVENT)
        self.contacts = ros.listen(PointCloud2, "impact/contact", EVENT)
        self.node = ros.make(BaseNode, {"base.topic": "/base/cmd_vel", "base.touch": kind, "rebound.restitution": 0.5})
        self.poses = ros.publisher(Odometry, "mocap/odom", POSE_PUBLISHED)
        self.touches = ros.publisher(message_type, "/touch", EVENT)

    def touch(self, message) -> None:
        for _ in range(5):
            now = seconds(self.ros.probe.get_clock())
            state = State(now, np.array([1.0, 2.0]), np.array([0.8, 0.0]), np.pi / 2)
            self.poses.publish(state_to_odometry(state, "map", "base_link", 0.0))
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


def test_messages_that_are_not_installed_are_named(ros):
    with pytest.raises(ParameterError, match="ArmorHit of robomaster_msgs is not"):
        ros.make(BaseNode, {"base.topic": "/base/cmd_vel", "base.touch": "hit"})


def test_a_hit_at_a_side_by_robomasters_own_messages(ros, real_messages):
    kind = real_messages("robomaster_msgs.msg").ArmorHit
    bench = TouchBench(ros, "hit", kind)
    bench.touch(kind(type=kind.IR, location=kind.BOTTOM_RIGHT))
    assert not bench.impacts
    bench.touch(kind(type=kind.COLLISION, location=kind.BOTTOM_RIGHT))
    assert ros.wait_until(lambda: bench.impacts)
    np.testing.assert_allclose((bench.impacts[0].vector.x, bench.impacts[0].vector.y), (-1.2, 0.0), atol=1e-9)
