"""A body that the motion capture loses, in each way it can tell: the robot stops, and goes on when it is seen again."""

import copy
import json
import math
from functools import partial

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Pose, PoseStamped, Quaternion, Twist, Vector3Stamped
from nav_msgs.msg import Odometry

from collplan_core.sensing.pose_filter import PoseSample
from collplan_core.worlds import load_world
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import prepare
from collplan_ros.messages.conversions import goal_to_message, pose_to_message, state_from_odometry
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT, LATCHED, NEWEST, POSE_PUBLISHED, POSE_SUBSCRIBED
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from collplan_ros.nodes.planner_node import PlannerNode
from omnipuck_sim.node.simulator_node import SimulatorNode


def lost(orientation):
    """At the origin, with this orientation."""

    def form(message, last):
        return PoseStamped(header=message.header, pose=Pose(orientation=orientation))

    return form


def not_a_number(message, last):
    wrong = copy.deepcopy(message)
    wrong.pose.orientation = Quaternion(x=math.nan, y=math.nan, z=math.nan, w=math.nan)
    return wrong


def held(message, last):
    return PoseStamped(header=message.header, pose=last.pose)


FORMS = {
    "zeros": lost(Quaternion(x=0.0, y=0.0, z=0.0, w=0.0)),
    "zeros_and_a_unit_quaternion": lost(Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)),
    "nan_quaternion": not_a_number,
    "frozen": held,
    "silence": lambda message, last: None,
}


def moving(k):
    """Pose k of a drive at 100 Hz."""
    return pose_to_message(PoseSample(5.0 + 0.01 * k, np.array([1.0 + 0.005 * k, 1.0]), 0.3), "map")


@pytest.mark.parametrize("name", FORMS)
def test_nothing_comes_out_while_the_body_is_lost(ros, name):
    odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    impacts = ros.listen(Vector3Stamped, "impact", EVENT)
    reports = ros.listen(DiagnosticArray, "/diagnostics", DIAGNOSTICS_SUBSCRIBED)
    node = ros.make(MocapNode)
    poses = ros.publisher(PoseStamped, "mocap/pose", POSE_PUBLISHED)
    assert ros.wait_until(lambda: node.count_subscribers("mocap/odom") and reports)

    def send(messages):
        for message in filter(None, messages):
            due = node._counts["received"] + 1
            poses.publish(message)
            assert ros.wait_until(partial(received, node, due))

    send(moving(k) for k in range(20))
    send(FORMS[name](moving(k), moving(19)) for k in range(20, 60))
    assert ros.wait_until(lambda: node._poses_clock.age(1e-9 * node._local.now().nanoseconds) > 0.15)
    node._diagnostics.publish()
    assert ros.wait_until(lambda: reports[-1].status[0].level != b"\0")
    assert [round(100 * (state_from_odometry(o, "map", "base_link").stamp - 5.0)) for o in odometry] == list(
        range(6, 20)
    )
    send(moving(k) for k in range(60, 80))
    assert ros.wait_until(lambda: len(odometry) == 14 + 14)
    state = state_from_odometry(odometry[-1], "map", "base_link")
    np.testing.assert_allclose([*state.position, *state.velocity], [1.395, 1.0, 0.5, 0.0], atol=1e-6)
    assert not impacts


def received(node, count):
    return node._counts["received"] == count


@pytest.mark.parametrize("accepted", [False, True])
def test_a_pose_that_repeats_itself(ros, accepted):
    """A robot at rest in a simulation without noise, too: there a parameter accepts it."""
    odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    node = ros.make(MocapNode, {"mocap.accept_frozen": accepted})
    poses = ros.publisher(PoseStamped, "mocap/pose", POSE_PUBLISHED)
    assert ros.wait_until(lambda: node.count_subscribers("mocap/odom"))
    for k in range(20):
        poses.publish(pose_to_message(PoseSample(5.0 + 0.01 * k, np.array([1.0, 1.0]), 0.3), "map"))
        assert ros.wait_until(partial(received, node, k + 1))
    assert ros.wait_until(lambda: len(odometry) == (14 if accepted else 0))
    assert node._counts["repeated"] == (0 if accepted else 19)


@pytest.mark.parametrize(
    ("given", "accepted"),
    [
        ({}, False),
        ({"noise": 0.0}, True),
        ({"mocap_noise": 0.0}, True),
        ({"noise": 0.0, "accept_frozen": False}, False),
    ],
)
def test_bringup_accepts_them_where_it_simulates_without_noise(tmp_path, given, accepted):
    groups = {"simulator": {k: v for k, v in given.items() if "noise" in k}}
    groups["mocap"] = {k: v for k, v in given.items() if "noise" not in k}
    path = tmp_path / "parameters.yaml"
    path.write_text(json.dumps({"/**": {"ros__parameters": groups}}))
    assert prepare(Options(params=path)).settings.mocap.accept_frozen is accepted


def test_robot_stops_and_goes_on(ros):
    commands = ros.listen(Twist, "cmd_vel", NEWEST)
    statuses = ros.listen(GoalStatus, "goal_status", LATCHED)
    occluder = Occluder(ros)
    ros.make(
        SimulatorNode,
        {"simulator.world": "l_corridor", "simulator.seed": 3},
        cli_args=["--ros-args", "-r", "mocap/pose:=seen/pose"],
    )
    mocap = ros.make(MocapNode)
    ros.make(LidarNode, {"lidar.world": "l_corridor"})
    # all nodes share a thread here, and poses wait in its queues
    planner, controller = ros.make(PlannerNode), ros.make(ControllerNode, {"limits.motion_delay": 0.4})
    goals = ros.publisher(PoseStamped, "goal_pose", EVENT)
    assert ros.wait_until(lambda: planner._loop._sensors.scan_stamp and controller._loop._sensors.scan_stamp)
    goals.publish(goal_to_message(load_world("l_corridor").goal, "map"))

    def speed():
        return math.hypot(commands[-1].linear.x, commands[-1].linear.y)

    for name, form in FORMS.items():
        assert ros.wait_until(lambda: commands and speed() > 0.2), f"does not go on before {name}"
        published = mocap._counts["published"]
        occluder.form = form
        assert ros.wait_until(lambda: speed() == 0.0), f"drives on while lost by {name}"
        assert mocap._counts["published"] - published <= 2
        occluder.form = None
    assert ros.wait_until(lambda: statuses[-1].status == GoalStatus.STATUS_SUCCEEDED, timeout=30.0)
    assert mocap._counts["relocations"] == 0


class Occluder:
    """Between the cameras and mocap_node; hands on what `form` makes of a pose, or the pose where there is none."""

    def __init__(self, ros):
        self.form = None
        self._last = None
        self._publisher = ros.probe.create_publisher(PoseStamped, "mocap/pose", POSE_PUBLISHED)
        ros.probe.create_subscription(PoseStamped, "seen/pose", self._take, POSE_SUBSCRIBED)

    def _take(self, message):
        handed_on = message
        if self.form is None:
            self._last = message
        else:
            handed_on = self.form(message, self._last)
        if handed_on is not None:
            self._publisher.publish(handed_on)
