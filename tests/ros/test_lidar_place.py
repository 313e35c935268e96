"""The LIDAR's place from /tf_static: the chain of transforms, and bringup's listening."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from geometry_msgs.msg import TransformStamped
from hypothesis import given
from hypothesis import strategies as st
from rclpy.qos import DurabilityPolicy, QoSProfile
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import LaserScan

from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.lidar_place import Link, mount_in, with_lidar_place
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import prepare
from collplan_ros.messages.conversions import quaternion_from_yaw
from collplan_ros.messages.qos import SENSOR_DATA

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
UPSIDE_DOWN = Rotation.from_euler("x", np.pi)
level = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-3.0, 3.0), st.booleans())


def link(parent: str, x: float, y: float, yaw: float, inverted: bool = False) -> Link:
    turn = Rotation.from_euler("z", yaw)
    return Link(parent, np.array([x, y, 0.1]), turn * UPSIDE_DOWN if inverted else turn)


@given(chain=st.lists(level, min_size=1, max_size=4), point=st.tuples(st.floats(-2, 2), st.floats(-2, 2)))
def test_a_point_seen_by_the_lidar_is_where_the_chain_puts_it(chain, point):
    names = ["base_link", *map(str, range(len(chain)))]
    links = {child: link(parent, *each) for parent, child, each in zip(names, names[1:], chain, strict=False)}
    mount = mount_in(links, "base_link", names[-1])
    seen = np.array([*point, 0.0])
    for name in reversed(names[1:]):
        seen = links[name].position + links[name].rotation.apply(seen)
    x, y = point[0], -point[1] if mount.mirrored else point[1]
    turned = math.cos(mount.yaw) * x - math.sin(mount.yaw) * y, math.sin(mount.yaw) * x + math.cos(mount.yaw) * y
    np.testing.assert_allclose((mount.x + turned[0], mount.y + turned[1]), seen[:2], atol=1e-9)


def test_frames_that_nothing_joins_have_no_place_and_a_tilted_lidar_is_refused():
    links = {"laser": link("mast", 0.1, 0.0, 0.0), "mast": link("other_base", 0.0, 0.0, 0.0), "a": link("a", 0, 0, 0)}
    assert mount_in(links, "base_link", "laser") is None
    assert mount_in(links, "base_link", "a") is None
    links["laser"] = Link("base_link", np.zeros(3), Rotation.from_euler("y", 0.6))
    with pytest.raises(StartError, match="laser is tilted by 34 degrees on base_link"):
        mount_in(links, "base_link", "laser")


def prepared(tmp_path, **scan):
    values = "".join(f", {key}: {value}" for key, value in scan.items())
    parameters = tmp_path / "base.yaml"
    parameters.write_text(f"/**: {{ros__parameters: {{robot: {{radius: 0.15}}, scan: {{median: 1{values}}}}}}}")
    about = {"robot": "base:/cmd_vel", "scan": "real", "network": "local", "params": parameters, "goal": (1.0, 0.0)}
    return prepare(Options(**about))


def test_bringup_takes_it_from_tf_static_unless_a_parameter_says_it(ros, real_messages, tmp_path):
    said = prepared(tmp_path, offset_x=0.1)
    assert with_lidar_place(said) == (said, "")
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
    preparation, words = found.result()
    taken = preparation.settings.scan
    assert (taken.frame, *taken.offset, taken.mirrored) == ("laser", 0.12, 0.0, pytest.approx(math.pi / 2), False)
    assert "laser is 0.120 m forward" in words


def test_without_a_transform_it_is_said_where_the_lidar_is_taken_to_be(ros, tmp_path):
    preparation, words = with_lidar_place(prepared(tmp_path, frame="laser"))
    assert preparation.settings.scan.offset == (0.0, 0.0, 0.0)
    assert "no transform from base_link to laser" in words
