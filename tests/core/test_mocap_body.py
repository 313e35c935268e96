"""Units, axes and the offset of the markers: what is measured becomes the robot's pose."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.parameters import Mocap
from collplan_core.sensing.mocap_body import MeasuredPose, robot_pose, with_offset
from collplan_core.sensing.pose_filter import PoseError, PoseSample

metres = st.floats(-20.0, 20.0)
short = st.floats(-1.0, 1.0)
angles = st.floats(-math.pi, math.pi)


def measured(position=(0.0, 0.0, 0.0), quaternion=(0.0, 0.0, 0.0, 1.0), frame="map", stamp=1.0):
    return MeasuredPose(frame, stamp, tuple(position), tuple(quaternion))


def about(axis, angle):
    """x, y, z, w of a turn about a unit vector."""
    return (*(math.sin(angle / 2) * np.array(axis)), math.cos(angle / 2))


def same_angle(a, b, tolerance=1e-9):
    return abs(math.remainder(a - b, math.tau)) < tolerance


def test_an_offset_by_hand():
    """Markers 3 cm ahead of the centre and 1 cm left of it, turned by 90 degrees; the robot looks along y."""
    body = with_offset(PoseSample(0.0, np.array([1.0, 2.0]), math.pi / 2), 0.03, 0.01, math.pi / 2)
    np.testing.assert_allclose(body.position, [0.99, 2.03], atol=1e-12)
    assert same_angle(body.yaw, math.pi)


@given(metres, metres, angles, short, short, angles, st.sampled_from(["m", "mm"]), st.sampled_from(["z_up", "y_up"]))
def test_what_a_motion_capture_measures_of_a_robot_is_undone(x, y, yaw, ahead, left, turned, units, axes):
    body = with_offset(PoseSample(1.0, np.array([x, y]), yaw), ahead, left, turned)
    scale = {"m": 1.0, "mm": 1000.0}[units]
    (px, py), height = scale * body.position, scale * 0.1
    if axes == "y_up":
        seen = measured((px, height, -py), about((0, 1, 0), body.yaw))
    else:
        seen = measured((px, py, height), about((0, 0, 1), body.yaw))
    mocap = Mocap(units=units, axes=axes, body_offset_x=ahead, body_offset_y=left, body_offset_yaw=turned)
    found = robot_pose(seen, 0.0, mocap)
    np.testing.assert_allclose(found.position, [x, y], atol=1e-9)
    assert same_angle(found.yaw, yaw)


def test_what_has_no_stamp_gets_the_time_of_its_receipt():
    assert robot_pose(measured(stamp=None), 7.5, Mocap()).stamp == 7.5
    assert robot_pose(measured(stamp=3.0), 7.5, Mocap()).stamp == 3.0


def test_lost_bodies_stay_lost_in_any_axes():
    table = [
        ("zeros", measured(quaternion=(0.0, 0.0, 0.0, 0.0))),
        ("not_finite", measured(quaternion=(math.nan,) * 4)),
        ("not_finite", measured((0.0, math.nan, 0.0))),
        ("quaternion", measured((1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 0.0))),
    ]
    for axes, (reason, pose) in product(("z_up", "y_up"), table):
        with pytest.raises(PoseError) as error:
            robot_pose(pose, 0.0, Mocap(axes=axes, units="mm", body_offset_x=0.1))
        assert error.value.reason == reason


def test_a_repeated_pose_is_told_by_its_last_bit():
    first = measured((1.0, 2.0, 0.0), stamp=1.0)
    assert measured((1.0, 2.0, 0.0), stamp=1.01).repeats(first)
    assert not measured((math.nextafter(1.0, 2.0), 2.0, 0.0)).repeats(first)
    assert not measured((1.0, 2.0, 0.0), about((0, 0, 1), 1e-9)).repeats(first)
    assert not first.repeats(None)
