"""bringup takes the LIDAR's place from /tf_static."""

import math
from concurrent.futures import ThreadPoolExecutor

import pytest
from geometry_msgs.msg import TransformStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import LaserScan

from collplan_ros.bringup.ending import StartError
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import prepare, with_lidar_place
from collplan_ros.messages.conversions import quaternion_from_yaw
from collplan_ros.messages.qos import SENSOR_DATA

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def prepared(tmp_path, **scan):
    values = "".join(f", {key}: {value}" for key, value in scan.items())
    parameters = tmp_path / "base.yaml"
    parameters.write_text(f"/**: {{ros__parameters: {{robot: {{radius: 0.15}}, scan: {{median: 1{values}}}}}}}")
    about = {"robot": "base:/cmd_vel", "scan": "real", "network": "local", "params": parameters, "goal": (1.0, 0.0)}
    return prepare(Options(**about))


def test_bringup_takes_it_from_tf_static_unless_a_parameter_says_it(ros, real_messages, tmp_path):
    said = prepared(tmp_path, offset_x=0.1)
    assert with_lidar_place(said) is said
    kind = real_messages("tf2_msgs.msg").TFMessage
    mount = TransformStamped(child_frame_id="laser")
    mount.header.frame_id = "base_link"
    mount.transform.translation.x, mount.transform.rotation = 0.12, quaternion_from_yaw(math.pi / 2)
    ros.publisher(kind, "/tf_static", LATCHED, matched=0).publish(kind(transforms=[mount]))
    scans, scan = ros.publisher(LaserScan, "/scan", SENSOR_DATA, matched=0), LaserScan()
    scan.header.frame_id = "laser"
    with ThreadPoolExecutor(1) as pool:
        found = pool.submit(with_lidar_place, prepared(tmp_path))

        def is_found():
            scans.publish(scan)
            return found.done()

        assert ros.wait_until(is_found, 20.0)
    preparation = found.result()
    taken = preparation.settings.scan
    assert (taken.frame, *taken.offset, taken.mirrored) == ("laser", 0.12, 0.0, pytest.approx(math.pi / 2), False)
    assert "laser is 0.120 m forward" in preparation.lidar


def test_a_given_use_sim_time_reaches_every_node_with_the_clock_of_the_whole_graph(tmp_path):
    before = prepared(tmp_path)
    (tmp_path / "sim.yaml").write_text("/**: {ros__parameters: {use_sim_time: true, robot: {radius: 0.15}}}")
    given = {"params": tmp_path / "sim.yaml", "goal": (1.0, 0.0), "network": "local"}
    follows = prepare(Options(robot="base:/cmd_vel", scan="real", **given))
    assert (before.simulated_time, follows.simulated_time) == ([], ["-p", "use_sim_time:=true"])
    assert [any("/clock" in word for word in each.remapped) for each in (before, follows)] == [True, False]
    with pytest.raises(StartError, match=r"use_sim_time: got true in .*sim.yaml, expected false"):
        prepare(Options(processes=True, params=tmp_path / "sim.yaml"))


def test_without_a_transform_it_is_said_where_the_lidar_is_taken_to_be(ros, tmp_path):
    preparation = with_lidar_place(prepared(tmp_path, frame="laser"))
    assert preparation.settings.scan.offset == (0.0, 0.0, 0.0)
    assert "no transform from base_link to laser" in preparation.lidar
