"""Poses and paths out of bytes: the same as rclpy reads, and a clear refusal of any others."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Path
from rclpy.serialization import deserialize_message, serialize_message

from collplan_core.sensing.pose_filter import PoseSample
from collplan_core.state import State
from collplan_ros.messages.conversions import header, pose_to_message, state_from_odometry, state_to_odometry
from collplan_ros.messages.plans import plan_to_path
from collplan_ros.messages.raw_reading import path_from_bytes, plan_from_bytes, state_from_bytes
from collplan_ros.messages.raw_writing import plan_to_bytes
from collplan_ros.messages.reading import MessageError, timed_plan

QUICK = settings(derandomize=True, deadline=None, max_examples=50)

METRES = st.floats(-1e4, 1e4)
FRAMES = st.text(st.characters(min_codepoint=1, max_codepoint=0x24F), min_size=1, max_size=12)
TIMES = st.floats(0.0, 2e9)


def path_of(stamp, poses, frame="map"):
    made = [pose_to_message(PoseSample(time, np.array([x, y]), 0.3), name) for time, x, y, name in poses]
    return Path(header=header(stamp, frame), poses=made)


@QUICK
@given(FRAMES, TIMES, st.lists(st.tuples(TIMES, METRES, METRES, FRAMES), max_size=12))
def test_a_path_is_what_was_sent_whatever_its_frames_are_called(frame, stamp, poses):
    """The names shift everything behind them, so that each alignment comes up."""
    told, times, positions = path_from_bytes(serialize_message(path_of(stamp, poses, frame)), frame)
    assert told == pytest.approx(stamp, abs=1e-6)
    np.testing.assert_allclose(times, [pose[0] for pose in poses], atol=1e-6)
    np.testing.assert_array_equal(positions, np.array([pose[1:3] for pose in poses]).reshape(-1, 2))


@QUICK
@given(FRAMES, TIMES, st.lists(st.tuples(METRES, METRES), min_size=2, max_size=9))
def test_a_plan_is_sent_as_rclpy_would(frame, stamp, positions):
    plan = timed_plan(stamp, stamp + 0.05 * np.arange(len(positions)), np.array(positions))
    raw = plan_to_bytes(plan, frame)
    assert deserialize_message(raw, Path) == plan_to_path(plan, frame)
    assert len(raw) == len(serialize_message(plan_to_path(plan, frame)))
    np.testing.assert_array_equal(plan_from_bytes(raw, frame).positions, plan.positions)


@QUICK
@given(FRAMES, FRAMES, st.tuples(METRES, METRES), st.tuples(METRES, METRES), st.floats(-3.0, 3.0))
def test_a_state_is_what_rclpy_reads(frame, base, position, velocity, yaw):
    message = state_to_odometry(State(12.25, np.array(position), np.array(velocity), yaw), frame, base)
    ours, theirs = state_from_bytes(serialize_message(message), frame, base), state_from_odometry(message, frame, base)
    assert ours.stamp == theirs.stamp
    np.testing.assert_array_equal(ours.position, theirs.position)
    np.testing.assert_allclose(ours.velocity, theirs.velocity, atol=1e-9)
    assert ours.yaw == pytest.approx(theirs.yaw, abs=1e-12)


@QUICK
@given(st.data())
def test_bytes_that_are_none_are_refused(data):
    whole = serialize_message(path_of(1.0, [(1.0, 0.5, 0.5, "map"), (2.0, 0.6, 0.6, "map")]))
    bad = bytearray(whole[: data.draw(st.integers(0, len(whole) - 1))])
    for _ in range(data.draw(st.integers(0, 3))):
        if bad:
            bad[data.draw(st.integers(0, len(bad) - 1))] = data.draw(st.integers(0, 255))
    for read in (lambda: path_from_bytes(bytes(bad), "map"), lambda: state_from_bytes(bytes(bad), "map", "base_link")):
        with suppress(MessageError):
            read()


def test_a_count_that_cannot_be_takes_no_memory_and_big_endian_is_refused():
    whole = bytearray(serialize_message(path_of(1.0, [])))
    whole[-4:] = (2**32 - 1).to_bytes(4, "little")
    with pytest.raises(MessageError):
        path_from_bytes(bytes(whole), "map")
    with pytest.raises(MessageError, match="encoding: got 0000"):
        path_from_bytes(b"\x00\x00\x00\x00" + bytes(40), "map")
