"""lidar_node alone, with a fake mocap_node."""

import itertools
from dataclasses import replace

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import MarkerArray

from collplan_core.parameters import Lidar
from collplan_core.state import State
from collplan_core.worlds import Mover, load_world, save_world
from collplan_core.worlds.raycast import simulate_scan
from collplan_ros.messages.conversions import state_to_odometry
from collplan_ros.messages.mover_markers import movers_to_markers
from collplan_ros.messages.qos import EVENT, POSE_PUBLISHED, SENSOR_DATA
from collplan_ros.messages.reading import scan_from_message
from collplan_ros.nodes.lidar_node import LidarNode
from node_health import NodeHealth


class LidarBench:
    def __init__(self, ros, parameters=None):
        self.ros = ros
        self.scans = ros.listen(LaserScan, "scan", SENSOR_DATA)
        self.health = NodeHealth(ros, "/lidar_node")
        self.node = ros.make(LidarNode, parameters)
        self.odometry = ros.publisher(Odometry, "mocap/odom", POSE_PUBLISHED)
        assert ros.wait_until(lambda: self.node.count_subscribers("scan") and self.health.reports)

    def send(self, state, frame="map"):
        self.odometry.publish(state_to_odometry(state, frame, "base_link"))


def start_of(world):
    return State(12.5, np.array(load_world(world).start, dtype=float), np.zeros(2), 0.4)


def test_a_scan_is_that_of_the_world_from_the_pose_one_for_one_pose(ros):
    beams = {"n_beams": 32, "angle_min": -1.0, "angle_span": 2.0}
    bench = LidarBench(ros, {"lidar.world": "random:3", **{f"lidar.{key}": value for key, value in beams.items()}})
    state = start_of("random:3")
    bench.send(state)
    assert ros.wait_until(lambda: bench.scans)
    assert bench.scans[0].header.frame_id == "base_link"
    scan = scan_from_message(bench.scans[0], "base_link")
    assert (scan.stamp, len(scan.ranges)) == (state.stamp, 32)
    np.testing.assert_allclose(
        scan.ranges, simulate_scan(load_world("random:3"), state, Lidar(**beams)).ranges, rtol=1e-6
    )
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
    assert bench.health.says("no pose on /mocap/odom", DiagnosticStatus.ERROR)


def test_movers_are_scanned_where_the_simulator_says_they_are(ros, tmp_path):
    floor, path = load_world("floor"), tmp_path / "moved.yaml"
    world = replace(floor, movers=(Mover(0.15, np.array([[0.4, 0.4], [2.0, 0.4]]), 0.5),))
    save_world(world, path)
    bench = LidarBench(ros, {"lidar.world": str(path)})
    movers = ros.publisher(MarkerArray, "ground_truth/movers", EVENT)
    state = start_of("floor")
    # at the pose's stamp it is between both places
    for ahead, x in ((-0.1, 1.0), (0.1, 1.1)):
        movers.publish(movers_to_markers(state.stamp + ahead, np.array([[x, 0.5, 0.5, 0.0, 0.15]]), "map"))
    assert ros.wait_until(lambda: movers.get_subscription_count() == 1)
    ros.spin(0.3)
    bench.send(state)
    assert ros.wait_until(lambda: bench.scans)
    expected = simulate_scan(floor, state, Lidar(), np.array([[1.05, 0.5, 0.15]]))
    np.testing.assert_allclose(scan_from_message(bench.scans[0], "base_link").ranges, expected.ranges, rtol=1e-6)
