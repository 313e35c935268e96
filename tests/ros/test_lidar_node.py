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
from collplan_core.sensing.spinning_lidar import LD19
from collplan_core.sensing.sweeps import sweeps_of
from collplan_core.state import State
from collplan_core.worlds import WorldError, load_world
from collplan_core.worlds.raycast import simulate_scan
from collplan_ros.messages.conversions import state_to_odometry
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, POSE_PUBLISHED, SENSOR_DATA
from collplan_ros.messages.reading import scan_from_message
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


# ---- a spinning sensor


class SpinningBench(LidarBench):
    """The node with the low-cost sensor, and poses of a robot that drives along x, at 100 Hz of their own clock."""

    def __init__(self, ros, **parameters):
        super().__init__(ros, {"lidar.sensor": "low_cost", **parameters})
        self.sent = []

    def drive(self, n, pause=0.0):
        """Sends the next n poses, each once the one before was taken, the first after a pause of the poses' clock."""
        start = start_of("corridor")
        for _ in range(n):
            stamp = self.sent[-1].stamp + 0.01 + pause if self.sent else start.stamp
            travelled = np.array([0.4 * (stamp - start.stamp), 0.0])
            self.sent.append(replace(start, stamp=stamp, position=start.position + travelled))
            self.send(self.sent[-1])
            assert self.ros.wait_until(self.has_taken_all)
            pause = 0.0

    def has_taken_all(self):
        taken = self.node._state
        return taken is not None and abs(taken.stamp - self.sent[-1].stamp) < 1e-6


@pytest.mark.parametrize("seed", [0, 5])
def test_a_spinning_sensor_scans_from_where_the_robot_was_at_each_beam(ros, seed):
    bench = SpinningBench(ros, **{"lidar.seed": seed})
    bench.drive(34)
    assert ros.wait_until(lambda: len(bench.scans) == 3)
    sweeps = sweeps_of(load_world("corridor"), Lidar(sensor="low_cost"), seed)
    expected = [scan for scan in map(sweeps.take_pose, bench.sent) if scan is not None]
    for message, scan in zip(bench.scans, expected, strict=True):
        received = scan_from_message(message, "base_link")
        assert received.stamp == pytest.approx(scan.stamp, abs=1e-6)
        np.testing.assert_allclose(received.ranges, scan.ranges, rtol=1e-5)
        assert message.time_increment == pytest.approx(LD19.time_increment)
        assert message.scan_time == pytest.approx(LD19.sweep_time)


def test_a_scan_comes_with_the_pose_that_is_its_latency_after_the_sweep(ros):
    bench = SpinningBench(ros)
    bench.drive(11)
    ros.spin(0.2)
    assert not bench.scans
    # 0.11 s after the first beam: the sweep and 10 ms of latency are over
    bench.drive(1)
    assert ros.wait_until(lambda: bench.scans)
    bench.drive(9)
    ros.spin(0.2)
    assert len(bench.scans) == 1


def test_no_scan_over_a_silence_of_the_poses(ros):
    bench = SpinningBench(ros)
    bench.drive(6)
    bench.drive(12, pause=1.0)
    assert ros.wait_until(lambda: bench.scans)
    ros.spin(0.2)
    assert [scan_from_message(message, "base_link").stamp for message in bench.scans] == [
        pytest.approx(bench.sent[6].stamp, abs=1e-6)
    ]
