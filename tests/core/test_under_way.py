"""The motion under way when a plan is made: by the velocity law, with rebounds, and as the first samples of a plan."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.local_map import build_local_map
from collplan_core.loop.delay_prediction import STEP, motion_under_way
from collplan_core.parameters import Settings
from collplan_core.plan import timed_path
from collplan_core.reflection import believed_ring, rebound
from collplan_core.state import State
from collplan_core.velocity_law import velocity_after, velocity_law
from collplan_core.worlds import parse_world
from collplan_core.worlds.raycast import simulate_scan

SETTINGS = Settings()
HALL = parse_world({"name": "hall", "bounds": [-1, -3, 3, 3], "start": [0.0, 0.0]}, "hall")
RADIUS = SETTINGS.robot.radius


def at(x=0.0, vx=0.0, vy=0.0, stamp=5.0):
    return State(stamp, np.array([x, 0.0]), np.array([vx, vy]), 0.3)


def map_at(state):
    return build_local_map(simulate_scan(HALL, state, SETTINGS.lidar), state, SETTINGS.robot, SETTINGS.local_map)


def sent(*rows):
    return np.array(rows, dtype=float).reshape(-1, 3)


IN_HALL = map_at(at())


@given(delay=st.integers(1, 40).map(lambda n: n * STEP), ux=st.floats(-1.2, 1.2), vx=st.floats(-1.0, 1.0))
def test_under_one_command_it_is_the_velocity_law(delay, ux, vx):
    state = at(vx=vx, vy=0.2)
    found = motion_under_way(state, sent((4.0, ux, 0.0)), delay, delay, IN_HALL, SETTINGS)
    end = velocity_after(velocity_law(SETTINGS.robot), vx, 0.2, ux, 0.0, delay)
    np.testing.assert_allclose(found.end.velocity, end, atol=1e-9)
    assert (found.end.stamp, found.end.yaw) == (pytest.approx(5.0 + delay), 0.3)
    np.testing.assert_array_equal(found.positions[0], state.position)
    assert not len(found.contacts.times)


def test_a_command_acts_so_long_after_it_was_sent_and_nothing_before_the_first():
    commands = sent((4.98, 1.0, 0.0), (5.02, -1.0, 0.0))
    found = motion_under_way(at(), commands, 0.1, 0.1, IN_HALL, SETTINGS)
    speeds, acts = found.velocities[:, 0], round((4.98 + 0.1 - 5.0) / STEP)
    assert not speeds[: acts + 1].any()
    assert (np.diff(speeds)[acts:] > 0.0).all()


def test_it_rebounds_from_a_wall_on_the_way_and_from_none_that_it_leaves():
    near = 3.0 - RADIUS - 0.05
    state = at(x=near, vx=1.0)
    found = motion_under_way(state, sent((4.0, 1.0, 0.0)), 0.1, 0.1, map_at(at(x=near)), SETTINGS)
    after = rebound(np.array([1.0, 0.0]), np.array([-1.0, 0.0]), believed_ring(SETTINGS))
    assert found.contacts.times == pytest.approx([5.05], abs=0.006)
    np.testing.assert_allclose(found.contacts.velocities_after[0], after, atol=1e-6)
    assert found.contacts.points[0, 0] == pytest.approx(3.0, abs=0.006)
    assert found.end.velocity[0] < 0.0
    beyond = at(x=3.0 - RADIUS + 0.004, vx=-1.0)
    found = motion_under_way(beyond, sent((4.0, -1.0, 0.0)), 0.05, 0.05, map_at(at(x=near)), SETTINGS)
    assert not len(found.contacts.times)
    assert found.end.velocity[0] == pytest.approx(-1.0)


def test_a_plan_made_from_its_end_begins_at_the_pose():
    found = motion_under_way(at(vx=0.5), sent((4.0, 0.5, 0.0)), 0.06, 0.06, IN_HALL, SETTINGS)
    times = found.end.stamp + np.array([0.0, 0.1])
    plan = timed_path(found.end.stamp, times, np.vstack([found.end.position, [1.0, 0.0]]), np.zeros((2, 2)))
    whole = found.before(plan)
    assert (whole.stamp, len(whole.times)) == (5.0, round(0.06 / STEP) + 2)
    assert (np.diff(whole.times) > 0.0).all()
    np.testing.assert_array_equal(whole.positions[-2:], plan.positions)
