"""A plan as the two messages that it leaves in, and back, and a pose out of bytes; what those may not hold."""

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Path
from rclpy.serialization import deserialize_message, serialize_message

from collplan_core.plan import Contacts, Plan, timed_path
from collplan_core.poses.pose_filter import PoseSample
from collplan_core.state import State
from collplan_ros.messages import conversions as c
from collplan_ros.messages.cloud_reading import AT_CONTACT, HOLDS, ON_PATH, PLAN, plan_from_message
from collplan_ros.messages.planner_clouds import plan_to_message
from collplan_ros.messages.raw_reading import plan_from_path, plan_to_path, state_from_bytes
from collplan_ros.messages.reading import MessageError

FEW = settings(derandomize=True, deadline=None, max_examples=40)
numbers = st.floats(-1e3, 1e3)
points = st.tuples(numbers, numbers).map(np.array)
FRAMES = st.text(st.characters(min_codepoint=1, max_codepoint=0x24F), min_size=1, max_size=12)


def plan_along(positions, begin=0.0, period=0.1, **more) -> Plan:
    positions = np.asarray(positions, dtype=float)
    return timed_path(begin, begin + period * np.arange(len(positions)), positions, 0.5 * positions, **more)


SHORT = plan_along([(0.0, 0.0), (0.1, 0.0), (0.2, 0.1)], 5.0)
TOUCHED, AFTER = np.array([[1.0, 0.5], [1.5, 0.0]]), np.array([[0.3, -0.4], [0.0, 0.2]])
BOUNCES = replace(
    SHORT,
    contacts=Contacts(np.array([5.05, 5.25]), TOUCHED, AFTER, np.array([[-1.0, 0.0], [0.0, 1.0]])),
    valid_until=5.15,
)


def stamp_of(index, stamp):
    return lambda path: setattr(path.poses[index].header, "stamp", c.stamp_from_seconds(stamp))


BAD_PATHS = (
    (lambda p: p.poses.__delitem__(slice(1, None)), "got 1, expected at least 2"),
    (lambda p: setattr(p.poses[1].pose.position, "x", math.nan), r"poses\[1\].*finite"),
    (stamp_of(2, 5.1), r"poses\[2\].*later"),
    (lambda p: setattr(p.header, "frame_id", "odom"), "frame_id"),
)


def test_paths_that_are_refused():
    for change, words in BAD_PATHS:
        message = deserialize_message(plan_to_path(BOUNCES, "map"), Path)
        change(message)
        with pytest.raises(MessageError, match=words):
            plan_from_path(serialize_message(message), "map")


def table_of(message):
    """The points of a message, as an array that changes them."""
    formats = [(name, "<f8") for name in PLAN[:-1]] + [(PLAN[-1], "u1")]
    return np.frombuffer(message.data, np.dtype(formats))


BAD_CLOUDS = (
    (lambda m: setattr(m.header, "frame_id", "odom"), "frame_id"),
    (lambda m: setattr(m.fields[0], "name", "time"), "fields: got time"),
    (lambda m: m.data.pop(), "data: got"),
    (lambda m: table_of(m)["kind"].fill(AT_CONTACT), "got 0, expected at least 2"),
    (lambda m: table_of(m)["vx"].__setitem__(1, math.nan), "velocity that is not finite"),
    (lambda m: table_of(m)["t"].__setitem__(5, math.inf), "finite"),
    (lambda m: table_of(m)["t"].__setitem__(2, -1.0), "later"),
)


def test_clouds_that_are_refused():
    for change, words in BAD_CLOUDS:
        message = plan_to_message(BOUNCES, "map")
        change(message)
        with pytest.raises(MessageError, match=words):
            plan_from_message(message, "map")
    with pytest.raises(MessageError, match="got Path, expected sensor_msgs/PointCloud2"):
        plan_from_message(Path(), "map")


def test_by_hand_the_points_of_a_cloud():
    message = plan_to_message(BOUNCES, "map")
    assert message.header == c.header(5.0, "map")
    assert table_of(message).tolist() == [
        pytest.approx(row)
        for row in (
            (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, ON_PATH),
            (0.1, 0.1, 0.0, 0.05, 0.0, 0.0, 0.0, ON_PATH),
            (0.2, 0.2, 0.1, 0.1, 0.05, 0.0, 0.0, ON_PATH),
            (0.05, 1.0, 0.5, 0.3, -0.4, -1.0, 0.0, AT_CONTACT),
            (0.25, 1.5, 0.0, 0.0, 0.2, 0.0, 1.0, AT_CONTACT),
            (0.15, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, HOLDS),
        )
    ]


@FEW
@given(FRAMES, st.floats(0.0, 2e9), st.lists(points, min_size=2, max_size=9), st.booleans(), st.data())
def test_a_plan_comes_back_from_its_cloud_as_from_its_path_and_more(frame, begin, positions, alone, data):
    rows = np.array(data.draw(st.lists(st.tuples(*7 * [numbers]), max_size=4))).reshape(-1, 7)
    contacts = Contacts(begin + np.sort(np.abs(rows[:, 0])), rows[:, 1:3], rows[:, 3:5], rows[:, 5:])
    plan = plan_along(positions, begin, contacts=contacts, valid_until=begin + data.draw(st.floats(-1.0, 5.0)))
    if alone:
        plan = replace(plan, velocities=None)
    told, path = (
        plan_from_message(plan_to_message(plan, frame), frame),
        plan_from_path(plan_to_path(plan, frame), frame),
    )
    assert (path.velocities, path.valid_until, len(path.contacts.times)) == (None, None, 0)
    assert told.stamp == path.stamp
    # Unix time in seconds has steps of 0.24 us
    for one, other in ((told.times, path.times), (told.contacts.times, contacts.times)):
        np.testing.assert_allclose(one, other, atol=1e-6, rtol=0.0)
    np.testing.assert_array_equal(told.positions, path.positions)
    np.testing.assert_array_equal(told.velocities, plan.velocities)
    for name in ("points", "velocities_after", "normals"):
        np.testing.assert_array_equal(getattr(told.contacts, name), getattr(contacts, name))
    assert told.valid_until == pytest.approx(plan.valid_until, abs=1e-6)


# ---- paths and poses out of bytes, whatever their frames are called: names shift what is behind them


def path_of(stamp, poses, frame="map"):
    made = [c.pose_to_message(PoseSample(time, np.array([x, y]), 0.0), name) for time, x, y, name in poses]
    return Path(header=c.header(stamp, frame), poses=made)


@FEW
@given(FRAMES, st.floats(0.0, 2e9), st.lists(st.tuples(numbers, numbers, FRAMES), min_size=2, max_size=12))
def test_a_path_is_what_was_sent_whatever_its_frames_are_called(frame, stamp, poses):
    sent = [(stamp + 0.05 * k, *pose) for k, pose in enumerate(poses)]
    plan = plan_from_path(serialize_message(path_of(stamp, sent, frame)), frame)
    assert plan.stamp == pytest.approx(stamp, abs=1e-6)
    np.testing.assert_allclose(plan.times, [pose[0] for pose in sent], atol=1e-6)
    np.testing.assert_array_equal(plan.positions, np.array([pose[:2] for pose in poses]))
    same = path_of(stamp, [(*pose[:3], frame) for pose in sent], frame)
    raw = plan_to_path(timed_path(stamp, np.array([pose[0] for pose in sent]), plan.positions, plan.velocities), frame)
    assert deserialize_message(raw, Path) == same
    assert len(raw) == len(serialize_message(same))


@FEW
@given(
    FRAMES, FRAMES, st.floats(0.0, 2e9), st.tuples(numbers, numbers), st.tuples(numbers, numbers), st.floats(-3.0, 3.0)
)
def test_a_state_is_what_was_sent(frame, base, stamp, position, velocity, yaw):
    message = c.state_to_odometry(State(stamp, np.array(position), np.array(velocity), yaw), frame, base)
    state = state_from_bytes(serialize_message(message), frame, base)
    assert state.stamp == pytest.approx(stamp, abs=1e-6)
    np.testing.assert_array_equal(state.position, position)
    np.testing.assert_allclose(state.velocity, velocity, atol=1e-9)
    assert state.yaw == pytest.approx(yaw, abs=1e-12)


@FEW
@given(st.data())
def test_bytes_that_are_none_are_refused(data):
    plan = timed_path(1.0, np.array([1.0, 2.0]), np.eye(2), np.eye(2))
    whole = plan_to_path(plan, "map")
    bad = bytearray(whole[: data.draw(st.integers(0, len(whole) - 1))])
    for _ in range(data.draw(st.integers(0, 3))):
        if bad:
            bad[data.draw(st.integers(0, len(bad) - 1))] = data.draw(st.integers(0, 255))
    for read in (plan_from_path, lambda raw, frame: state_from_bytes(raw, frame, "base_link")):
        with suppress(MessageError):
            read(bytes(bad), "map")


def test_a_count_that_cannot_be_takes_no_memory_and_big_endian_is_refused():
    whole = bytearray(serialize_message(path_of(1.0, [])))
    whole[-4:] = (2**32 - 1).to_bytes(4, "little")
    with pytest.raises(MessageError):
        plan_from_path(bytes(whole), "map")
    with pytest.raises(MessageError, match="encoding: got 0000"):
        plan_from_path(b"\x00\x00\x00\x00" + bytes(40), "map")
