"""Plans and what goes with them to messages and back; what those may not hold."""

import math

import numpy as np
import pytest
from builtin_interfaces.msg import Duration
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

from collplan_core.plan import Candidates, Contacts, Plan
from collplan_ros.messages import conversions as c
from collplan_ros.messages import plans as m
from collplan_ros.messages.reading import MessageError, PathError, contacts_from_message, plan_from_path

FEW = settings(derandomize=True, deadline=None, max_examples=40)
numbers = st.floats(-1e3, 1e3)
points = st.tuples(numbers, numbers).map(np.array)


def sent(message):
    """The message after serialisation, as a listener receives it."""
    return deserialize_message(serialize_message(message), type(message))


# ---- when to be where


def plan_along(positions, begin=0.0, period=0.1):
    positions = np.asarray(positions, dtype=float)
    times = begin + period * np.arange(len(positions))
    nothing = Candidates(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    velocities = np.zeros_like(positions)
    return Plan(begin, times, positions, velocities, Contacts.none(), np.zeros(2), np.zeros(2), {}, nothing, 0)


@given(st.floats(0.0, 2e9), st.lists(points, min_size=2, max_size=20), st.floats(0.001, 1.0))
@FEW
def test_plan(begin, positions, period):
    plan = plan_along(positions, begin, period)
    back = plan_from_path(sent(m.plan_to_path(plan, "map")), "map")
    assert back.stamp == pytest.approx(plan.stamp, abs=1e-9)
    np.testing.assert_allclose(back.times, plan.times, atol=1e-9, rtol=0.0)
    np.testing.assert_array_equal(back.positions, plan.positions)


def test_velocities_of_a_plan_are_exact_on_a_parabola():
    t = 0.05 * np.arange(20)
    plan = plan_along(np.column_stack([0.3 * t**2, 1.0 - t]), period=0.05)
    back = plan_from_path(m.plan_to_path(plan, "map"), "map")
    np.testing.assert_allclose(back.velocities, np.column_stack([0.6 * t, np.full(20, -1.0)]), atol=1e-9)


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


def test_paths_that_are_refused():
    for change, words in BAD_PATHS:
        message = m.plan_to_path(plan_along([(0.0, 0.0), (0.1, 0.0), (0.2, 0.1)], 5.0), "map")
        change(message)
        with pytest.raises(PathError, match=words):
            plan_from_path(message, "map")


# ---- foreseen contacts

delays = st.lists(st.floats(0.0, 20.0), max_size=6).map(sorted)


@given(st.floats(0.0, 2e9), delays, st.data())
@FEW
def test_contacts(stamp, after, data):
    rows = st.tuples(numbers, numbers, numbers, numbers)
    table = np.array(data.draw(st.lists(rows, min_size=len(after), max_size=len(after)))).reshape(-1, 4)
    contacts = Contacts(stamp + np.array(after), table[:, :2], table[:, 2:])
    back_stamp, back = contacts_from_message(sent(m.contacts_to_message(contacts, stamp, "map", "puck")), "map")
    assert back_stamp == c.seconds_from_stamp(c.stamp_from_seconds(stamp))
    # Unix time in seconds has steps of 0.24 us
    np.testing.assert_allclose(back.times, contacts.times, atol=1e-6, rtol=0.0)
    np.testing.assert_array_equal(back.points, contacts.points)
    np.testing.assert_array_equal(back.velocities_after, contacts.velocities_after)


def contacts_message():
    """Two contacts, 0.25 s and 0.75 s after a plan of 5.0 s."""
    touched, after = np.array([[1.0, 0.5], [1.5, 0.0]]), np.array([[0.3, -0.4], [0.0, 0.2]])
    return m.contacts_to_message(Contacts(np.array([5.25, 5.75]), touched, after), 5.0, "map", "base_link")


def test_a_contact_in_its_message():
    message = contacts_message()
    assert message.header == c.header(5.0, "map")
    assert message.joint_names == ["base_link"]
    first = message.points[0]
    assert (first.transforms[0].translation.x, first.transforms[0].translation.y) == (1.0, 0.5)
    assert first.transforms[0].rotation.w == 1.0
    assert (first.velocities[0].linear.x, first.velocities[0].linear.y) == (0.3, -0.4)
    assert first.time_from_start == Duration(sec=0, nanosec=250_000_000)
    # two may come at once, in a corner
    message.points[1].time_from_start = first.time_from_start
    assert contacts_from_message(message, "map")[1].times.tolist() == [5.25, 5.25]


BAD_CONTACTS = (
    (lambda t: setattr(t.header, "frame_id", "odom"), "frame 'odom'"),
    (lambda t: t.points[1].transforms.clear(), r"points\[1\]\.transforms: got 0"),
    (lambda t: t.points[0].velocities.append(t.points[0].velocities[0]), r"points\[0\]\.velocities: got 2"),
    (lambda t: setattr(t.points[0].transforms[0].translation, "x", math.nan), r"points\[0\]\.transforms.*finite"),
    (lambda t: setattr(t.points[1].velocities[0].linear, "y", math.inf), r"points\[1\]\.velocities.*finite"),
    (lambda t: setattr(t.points[0], "time_from_start", Duration(sec=-1)), r"points\[0\].*got -1 s"),
    (lambda t: setattr(t.points[1], "time_from_start", Duration()), r"points\[1\].*got 0 s"),
)


def test_contacts_that_are_refused():
    for change, words in BAD_CONTACTS:
        message = contacts_message()
        change(message)
        with pytest.raises(MessageError, match=words):
            contacts_from_message(message, "map")


# ---- until when


@given(st.integers(0, 10**9), st.integers(0, 10**9))
@FEW
def test_validity(stamp, more):
    """Whole microseconds."""
    message = sent(m.validity_to_message(1e-6 * stamp, 1e-6 * (stamp + more), "/puck/planner_node"))
    assert message.source == "/puck/planner_node"
    assert m.validity_from_message(message) == pytest.approx((1e-6 * stamp, 1e-6 * (stamp + more)), abs=1e-9)
