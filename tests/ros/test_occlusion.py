"""A body that the motion capture loses, in each way it can tell: nothing comes out, and it goes on when it is seen."""

import copy
import json
import math

import numpy as np
import pytest
from geometry_msgs.msg import Pose, PoseStamped, Quaternion, Vector3Stamped
from nav_msgs.msg import Odometry

from collplan_core.sensing.pose_filter import PoseSample
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import prepare
from collplan_ros.messages.conversions import pose_to_message, state_from_odometry
from collplan_ros.messages.qos import EVENT, POSE_PUBLISHED, POSE_SUBSCRIBED
from collplan_ros.nodes.mocap_node import MocapNode
from node_health import NodeHealth


def lost(orientation):
    """At the origin, with this orientation."""
    return lambda message, last: PoseStamped(header=message.header, pose=Pose(orientation=orientation))


def not_a_number(message, last):
    wrong = copy.deepcopy(message)
    wrong.pose.orientation = Quaternion(x=math.nan, y=math.nan, z=math.nan, w=math.nan)
    return wrong


FORMS = {
    "zeros": lost(Quaternion(x=0.0, y=0.0, z=0.0, w=0.0)),
    "zeros_and_a_unit_quaternion": lost(Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)),
    "nan_quaternion": not_a_number,
    "frozen": lambda message, last: PoseStamped(header=message.header, pose=last.pose),
    "silence": lambda message, last: None,
}


def moving(k):
    """Pose k of a drive at 100 Hz."""
    return pose_to_message(PoseSample(5.0 + 0.01 * k, np.array([1.0 + 0.005 * k, 1.0]), 0.3), "map")


@pytest.mark.parametrize("name", FORMS)
def test_nothing_comes_out_while_the_body_is_lost(ros, name):
    odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    impacts = ros.listen(Vector3Stamped, "impact", EVENT)
    health = NodeHealth(ros, "/mocap_node")
    ros.make(MocapNode)
    poses = ros.publisher(PoseStamped, "mocap/pose", POSE_PUBLISHED)

    def send(messages):
        for message in filter(None, messages):
            poses.publish(message)
            ros.spin(0.002)

    send(moving(k) for k in range(20))
    assert ros.wait_until(lambda: len(odometry) == 14)
    send(FORMS[name](moving(k), moving(19)) for k in range(20, 60))
    assert ros.wait_until(lambda: health.newest.level not in (b"\0", b"\3"))
    assert [round(100 * (state_from_odometry(o, "map", "base_link").stamp - 5.0)) for o in odometry] == list(
        range(6, 20)
    )
    send(moving(k) for k in range(60, 80))
    assert ros.wait_until(lambda: len(odometry) == 14 + 14)
    state = state_from_odometry(odometry[-1], "map", "base_link")
    np.testing.assert_allclose([*state.position, *state.velocity], [1.395, 1.0, 0.5, 0.0], atol=1e-6)
    assert not impacts


@pytest.mark.parametrize("accepted", [False, True])
def test_a_pose_that_repeats_itself(ros, accepted):
    """A robot at rest in a simulation without noise, too: there a parameter accepts it."""
    odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    health = NodeHealth(ros, "/mocap_node")
    ros.make(MocapNode, {"mocap.accept_frozen": accepted})
    poses = ros.publisher(PoseStamped, "mocap/pose", POSE_PUBLISHED)
    for k in range(20):
        poses.publish(pose_to_message(PoseSample(5.0 + 0.01 * k, np.array([1.0, 1.0]), 0.3), "map"))
        ros.spin(0.002)
    assert health.counts("received", 20)
    assert len(odometry) == (14 if accepted else 0)
    assert health.count("repeated") == (0 if accepted else 19)


def test_bringup_accepts_them_where_it_simulates_without_noise(tmp_path):
    for simulator, mocap, accepted in (
        ({}, {}, False),
        ({"noise": 0.0}, {}, True),
        ({"mocap_noise": 0.0}, {}, True),
        ({"noise": 0.0}, {"accept_frozen": False}, False),
    ):
        path = tmp_path / "parameters.yaml"
        path.write_text(json.dumps({"/**": {"ros__parameters": {"simulator": simulator, "mocap": mocap}}}))
        assert prepare(Options(params=path)).settings.mocap.accept_frozen is accepted, (simulator, mocap)
