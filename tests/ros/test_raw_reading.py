"""Poses and paths out of bytes: the same as rclpy reads, and a clear refusal of any others."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Path
from rclpy.serialization import deserialize_message, serialize_message

from collplan_core.plan import timed_path
from collplan_core.poses.pose_filter import PoseSample
from collplan_core.state import State
from collplan_ros.messages.conversions import header, pose_to_message, state_to_odometry
from collplan_ros.messages.raw_reading import plan_from_path, state_from_bytes
from collplan_ros.messages.raw_writing import plan_to_path
from collplan_ros.messages.reading import MessageError

QUICK = settings(derandomize=True, deadline=None, max_examples=50)

METRES = st.floats(-1e4, 1e4)
FRAMES = st.text(st.characters(min_codepoint=1, max_codepoint=0x24F), min_size=1, max_size=12)
TIMES = st.floats(0.0, 2e9)


def path_of(stamp, poses, frame="map"):
    made = [pose_to_message(PoseSample(time, np.array([x, y]), 0.0), name) for time, x, y, name in poses]
    return Path(header=header(stamp, frame), poses=made)


@QUICK
@given(FRAMES, TIMES, st.lists(st.tuples(METRES, METRES, FRAMES), min_size=2, max_size=12))
def test_a_path_is_what_was_sent_whatever_its_frames_are_called(frame, stamp, poses):
    """The names shift everything behind them, so that each alignment comes up."""
    sent = [(stamp + 0.05 * k, *pose) for k, pose in enumerate(poses)]
    plan = plan_from_path(serialize_message(path_of(stamp, sent, frame)), frame)
    assert plan.stamp == pytest.approx(stamp, abs=1e-6)
    np.testing.assert_allclose(plan.times, [pose[0] for pose in sent], atol=1e-6)
    np.testing.assert_array_equal(plan.positions, np.array([pose[:2] for pose in poses]))
    same = path_of(stamp, [(*pose[:3], frame) for pose in sent], frame)
    raw = plan_to_path(timed_path(stamp, np.array([pose[0] for pose in sent]), plan.positions, plan.velocities), frame)
    assert deserialize_message(raw, Path) == same
    assert len(raw) == len(serialize_message(same))


@QUICK
@given(FRAMES, FRAMES, TIMES, st.tuples(METRES, METRES), st.tuples(METRES, METRES), st.floats(-3.0, 3.0))
def test_a_state_is_what_was_sent(frame, base, stamp, position, velocity, yaw):
    message = state_to_odometry(State(stamp, np.array(position), np.array(velocity), yaw), frame, base)
    state = state_from_bytes(serialize_message(message), frame, base)
    assert state.stamp == pytest.approx(stamp, abs=1e-6)
    np.testing.assert_array_equal(state.position, position)
    np.testing.assert_allclose(state.velocity, velocity, atol=1e-9)
    assert state.yaw == pytest.approx(yaw, abs=1e-12)


@QUICK
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
