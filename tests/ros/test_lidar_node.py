"""lidar_node alone, with a fake mocap_node."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from collplan_core.parameters import Lidar
from collplan_core.state import State
from collplan_core.worlds import WorldError, load_world
from collplan_core.worlds.raycast import simulate_scan
from collplan_ros.messages.conversions import scan_from_message, state_to_odometry
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, POSE_PUBLISHED, SENSOR_DATA
from collplan_ros.nodes.lidar_node import LidarNode


class LidarBench:
    """The node, a source of poses, and what it says."""

    def __init__(self, ros, parameters=None):
        self.ros = ros
        self.scans = ros.listen(LaserScan, "scan", SENSOR_DATA)
        self.reports = ros.listen(DiagnosticArray, "/diagnostics", DIAGNOSTICS_SUBSCRIBED)
        self.node = ros.make(LidarNode, parameters)
        self.odometry = ros.publisher(Odometry, "mocap/odom", POSE_PUBLISHED)
        assert ros.wait_until(lambda: self.node.count_subscribers("scan") and self.reports)

    def send(self, state, frame="map"):
        self.odometry.publish(state_to_odometry(state, frame, "base_link"))

    def status(self):
        self.node._diagnostics.publish()
        before = len(self.reports)
        assert self.ros.wait_until(lambda: len(self.reports) > before)
        return self.reports[-1].status[0]


def start_of(world):
    return State(12.5, np.array(load_world(world).start, dtype=float), np.zeros(2), 0.4)


@pytest.mark.parametrize("world", ["corridor", "random:3"])
def test_scan_is_that_of_the_world_from_the_pose(ros, world):
    bench = LidarBench(ros, {"lidar.world": world})
    state = start_of(world)
    bench.send(state)
    assert ros.wait_until(lambda: bench.scans)
    message = bench.scans[0]
    assert message.header.frame_id == "base_link"
    scan = scan_from_message(message, "base_link")
    assert scan.stamp == state.stamp
    np.testing.assert_allclose(scan.ranges, simulate_scan(load_world(world), state, Lidar()).ranges, rtol=1e-6)


def test_one_scan_for_one_pose(ros):
    bench = LidarBench(ros)
    bench.send(start_of("corridor"))
    assert ros.wait_until(lambda: bench.scans)
    ros.spin(0.2)
    assert len(bench.scans) == 1


def test_no_scan_from_an_old_pose(ros):
    bench = LidarBench(ros, {"lidar.rate": 1.0, "limits.pose_age": 0.5})
    state = start_of("corridor")
    # poses come until a scan was due; the next one comes just after, and is too old when a scan is due again
    stamps = itertools.count(1)
    poses = ros.probe.create_timer(0.05, lambda: bench.send(replace(state, stamp=state.stamp + 0.05 * next(stamps))))
    assert ros.wait_until(lambda: bench.scans)
    ros.spin(0.1)
    ros.probe.destroy_timer(poses)
    ros.spin(1.5)
    assert len(bench.scans) == 1
    status = bench.status()
    assert status.level == DiagnosticStatus.ERROR
    assert "no pose on /mocap/odom for" in status.message


def test_poses_that_are_refused(ros):
    bench = LidarBench(ros)
    state = start_of("corridor")
    bench.send(State(1.0, np.array([math.nan, 0.0]), np.zeros(2), 0.0))
    bench.send(state, frame="odom")
    assert ros.wait_until(lambda: bench.node._inputs.refusals["pose"] == 2)
    ros.spin(0.1)
    assert not bench.scans
    status = bench.status()
    assert status.level == b"\x01"
    assert "'odom', expected 'map'" in status.message


def test_beams_are_parameters(ros):
    bench = LidarBench(ros, {"lidar.n_beams": 30, "lidar.angle_min": -1.0, "lidar.angle_span": 2.0})
    bench.send(start_of("corridor"))
    assert ros.wait_until(lambda: bench.scans)
    assert len(bench.scans[0].ranges) == 30
    assert bench.scans[0].angle_min == pytest.approx(-1.0)
    assert bench.scans[0].angle_max == pytest.approx(1.0, abs=0.08)


@pytest.mark.parametrize("world", ["nowhere", "none.yaml", "random:many"])
def test_world_that_does_not_exist(ros, world):
    with pytest.raises(WorldError, match=world.split(":", maxsplit=1)[0]):
        ros.make(LidarNode, {"lidar.world": world})
