"""A plan as the two messages that it leaves in, and back; what those may not hold."""

import math
from dataclasses import replace

import numpy as np
import pytest
from builtin_interfaces.msg import Duration
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Path
from rclpy.serialization import deserialize_message, serialize_message
from trajectory_msgs.msg import MultiDOFJointTrajectory

from collplan_core.plan import Contacts, Plan, timed_path
from collplan_ros.messages import conversions as c
from collplan_ros.messages.plan_trajectory import plan_from_trajectory, plan_to_trajectory
from collplan_ros.messages.raw_reading import plan_from_path
from collplan_ros.messages.raw_writing import plan_to_path
from collplan_ros.messages.reading import MessageError, seconds_from_stamp

FEW = settings(derandomize=True, deadline=None, max_examples=40)
numbers = st.floats(-1e3, 1e3)
points = st.tuples(numbers, numbers).map(np.array)
FRAMES = st.text(st.characters(min_codepoint=1, max_codepoint=0x24F), min_size=1, max_size=12)


def plan_along(positions, begin=0.0, period=0.1, **more) -> Plan:
    positions = np.asarray(positions, dtype=float)
    return timed_path(begin, begin + period * np.arange(len(positions)), positions, 0.5 * positions, **more)


SHORT = plan_along([(0.0, 0.0), (0.1, 0.0), (0.2, 0.1)], 5.0)
BOUNCES = replace(
    SHORT,
    contacts=Contacts(np.array([5.05, 5.25]), np.array([[1.0, 0.5], [1.5, 0.0]]), np.array([[0.3, -0.4], [0.0, 0.2]])),
    valid_until=5.15,
)


def test_velocities_of_a_path_are_exact_on_a_parabola():
    t = 0.05 * np.arange(20)
    plan = plan_along(np.column_stack([0.3 * t**2, 1.0 - t]), period=0.05)
    back = plan_from_path(plan_to_path(plan, "map"), "map")
    np.testing.assert_allclose(back.velocities, np.column_stack([0.6 * t, np.full(20, -1.0)]), atol=1e-9)
    assert back.valid_until is None


def stamp_of(index, stamp):
    return lambda path: setattr(path.poses[index].header, "stamp", c.stamp_from_seconds(stamp))


BAD_PATHS = (
    (lambda p: p.poses.clear(), "got 0, expected at least 2"),
    (lambda p: p.poses.__delitem__(slice(1, None)), "got 1, expected at least 2"),
    (lambda p: setattr(p.poses[1].pose.position, "x", math.nan), r"poses\[1\].*finite"),
    (lambda p: setattr(p.poses[2].pose.position, "y", math.inf), r"poses\[2\].*finite"),
    (stamp_of(2, 5.1), r"poses\[2\].*later"),
    (stamp_of(1, 4.0), r"poses\[1\].*later"),
    (lambda p: setattr(p.header, "frame_id", "odom"), "frame_id"),
)
BAD_TRAJECTORIES = (
    (lambda t: setattr(t.header, "frame_id", "odom"), "frame_id"),
    (lambda t: setattr(t, "joint_names", ["robot", "command"]), "joint_names: got robot, command"),
    (lambda t: t.points.clear(), "points: got 0"),
    (lambda t: t.points.__delitem__(slice(1, None)), "got 0, expected at least 2"),
    (lambda t: t.points[1].transforms.pop(), "points: "),
    (lambda t: t.points[0].velocities.pop(), "points: "),
    (lambda t: t.points[0].accelerations.append(t.points[0].velocities[0]), "points: "),
    (lambda t: setattr(t.points[0].transforms[0].translation, "x", math.nan), "finite"),
    (lambda t: setattr(t.points[1].velocities[1].linear, "y", math.inf), "finite"),
    (lambda t: setattr(t.points[2], "time_from_start", Duration(sec=-1)), "later"),
)


@pytest.mark.parametrize(
    ("kind", "write", "read", "table"),
    [
        (Path, plan_to_path, plan_from_path, BAD_PATHS),
        (
            MultiDOFJointTrajectory,
            plan_to_trajectory,
            plan_from_trajectory,
            BAD_TRAJECTORIES,
        ),
    ],
)
def test_what_is_refused(kind, write, read, table):
    for change, words in table:
        message = deserialize_message(write(BOUNCES, "map"), kind)
        change(message)
        with pytest.raises(MessageError, match=words):
            read(serialize_message(message), "map")


def test_each_point_of_a_trajectory_and_the_last_one_is_how_long_it_holds():
    message = deserialize_message(plan_to_trajectory(BOUNCES, "map"), MultiDOFJointTrajectory)
    assert message.header == c.header(5.0, "map")
    assert message.joint_names == ["robot", "contact"]
    expected = (  # after the stamp, robot, its velocity, touched, velocity afterwards
        (0.0, (0.0, 0.0), (0.0, 0.0), None, (0.0, 0.0)),
        (0.05, (0.05, 0.0), (0.025, 0.0), (1.0, 0.5), (0.3, -0.4)),
        (0.1, (0.1, 0.0), (0.05, 0.0), None, (0.0, 0.0)),
        (0.2, (0.2, 0.1), (0.1, 0.05), None, (0.0, 0.0)),
        (0.25, (0.2, 0.1), (0.1, 0.05), (1.5, 0.0), (0.0, 0.2)),
        (0.15, (0.15, 0.05), (0.075, 0.025), None, (0.0, 0.0)),
    )
    assert len(message.points) == len(expected)
    for point, (after, robot, velocity, touched, afterwards) in zip(message.points, expected, strict=True):
        assert seconds_from_stamp(point.time_from_start) == pytest.approx(after, abs=1e-9)
        places = [(each.translation.x, each.translation.y) for each in point.transforms]
        assert places[0] == pytest.approx(robot)
        assert math.isnan(places[1][0]) if touched is None else places[1] == touched
        speeds = [(each.linear.x, each.linear.y) for each in point.velocities]
        assert speeds == [pytest.approx(velocity), afterwards]
        assert [each.rotation.w for each in point.transforms] == [1.0, 1.0]


@FEW
@given(FRAMES, st.floats(0.0, 2e9), st.lists(points, min_size=2, max_size=9), st.data())
def test_a_plan_comes_back_from_its_trajectory_as_from_its_path_and_more(frame, begin, positions, data):
    rows = np.array(data.draw(st.lists(st.tuples(*5 * [numbers]), max_size=4))).reshape(-1, 5)
    contacts = Contacts(begin + np.sort(np.abs(rows[:, 0])), rows[:, 1:3], rows[:, 3:])
    plan = plan_along(positions, begin, contacts=contacts, valid_until=begin + data.draw(st.floats(-1.0, 5.0)))
    raw = plan_to_trajectory(plan, frame)
    # the names shift everything behind them, so that each alignment comes up
    assert len(raw) == len(serialize_message(deserialize_message(raw, MultiDOFJointTrajectory)))
    told, path = plan_from_trajectory(raw, frame), plan_from_path(plan_to_path(plan, frame), frame)
    for name in ("stamp", "times", "positions"):
        np.testing.assert_array_equal(getattr(told, name), getattr(path, name))
    np.testing.assert_array_equal(told.velocities, plan.velocities)
    for name in ("points", "velocities_after"):
        np.testing.assert_array_equal(getattr(told.contacts, name), getattr(contacts, name))
    # Unix time in seconds has steps of 0.24 us
    np.testing.assert_allclose(told.contacts.times, contacts.times, atol=1e-6, rtol=0.0)
    assert told.valid_until == pytest.approx(plan.valid_until, abs=1e-6)
