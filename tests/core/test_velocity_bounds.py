"""Bounds of the velocity, a disc or a box in the body frame: in planners, controller and checks of poses."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.control.follow import ControllerMemory, clip_command, cut_to_bounds, follow, saturate
from collplan_core.control.permission import is_relocated
from collplan_core.paper_planner import plan_cycle as paper
from collplan_core.paper_planner import trajectory
from collplan_core.parameters import Limits, Robot, Settings
from collplan_core.plan import timed_path
from collplan_core.poses.pose_filter import FRESH, SPEED, PoseSample, filter_pose
from collplan_core.state import State
from collplan_core.time_to_goal_planner import plan_cycle as time_to_goal
from collplan_core.time_to_goal_planner.arrival import straight_time
from collplan_core.velocity_bounds import fastest_along, room_along, share_along, velocity_bounds, within
from scenes import at_rest, box, map_of, rotation, unit, world_of
from time_to_goal_scenes import motion_in, open_field, problem_over

DISC, BOX = Robot(), Robot(velocity_shape="box")
V_MAX = DISC.max_speed
SQRT2 = math.sqrt(2.0)
FEW = settings(derandomize=True, deadline=None, max_examples=10, print_blob=True)
vectors = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)).map(np.array)
yaws = st.floats(-4.0, 4.0)
TURN = world_of([box(-1.0, 0.2, 0.35, 0.25), box(0.65, -0.5, 0.75, 0.8)])
SHAPES = {
    shape: Settings().with_values({"robot.velocity_shape": shape, "time_to_goal.proposals": 60})
    for shape in ("disc", "box")
}


def largest_axis(velocities, yaw: float) -> float:
    """Largest component in the body frame of velocities (n, 2) in the world's."""
    return float(np.abs(np.atleast_2d(velocities) @ rotation(yaw)).max(initial=0.0))


@given(v=vectors, yaw=yaws)
def test_a_velocity_is_shortened_to_the_box_or_left_as_it_is(v, yaw):
    bounds = velocity_bounds(BOX, yaw)
    cut = np.array(within(bounds, *v.tolist()))
    assert largest_axis(cut, yaw) <= V_MAX * (1 + 1e-12)
    assert cut @ v == pytest.approx(np.hypot(*cut) * np.hypot(*v), abs=1e-9)
    np.testing.assert_allclose(cut_to_bounds(v, bounds), cut, atol=1e-12)
    if largest_axis(v, yaw) > V_MAX:
        assert largest_axis(cut, yaw) == pytest.approx(V_MAX)
        assert np.hypot(*cut) == pytest.approx(fastest_along(bounds, *v.tolist()))
    elif largest_axis(v, yaw) < V_MAX * (1 - 1e-12):
        np.testing.assert_array_equal(cut, v)


@given(v=vectors, yaw=yaws)
def test_the_disc_is_cut_bit_by_bit_as_by_its_length_alone(v, yaw):
    bounds, (x, y) = velocity_bounds(DISC, yaw), v.tolist()
    speed = math.sqrt(x * x + y * y)
    assert within(bounds, x, y) == ((x * V_MAX / speed, y * V_MAX / speed) if speed > V_MAX else (x, y))
    np.testing.assert_array_equal(cut_to_bounds(v, bounds), saturate(v, V_MAX))
    assert (share_along(bounds, x, y), fastest_along(bounds, x, y), DISC.fastest) == (1.0, V_MAX, V_MAX)


@given(v=vectors, yaw=yaws, along=yaws, shape=st.sampled_from((DISC, BOX)))
def test_a_velocity_has_room_up_to_the_edge_and_no_further(v, yaw, along, shape):
    bounds, d = velocity_bounds(shape, yaw), unit(along)
    v = 0.99 * np.array(within(bounds, *v.tolist()))
    end = v + room_along(bounds, *v.tolist(), *d.tolist()) * d
    assert np.hypot(*end) * share_along(bounds, *end.tolist()) == pytest.approx(V_MAX, rel=1e-6)


def test_by_hand_a_box_turned_by_45_degrees_is_fastest_along_the_worlds_axes():
    bounds = velocity_bounds(BOX, np.pi / 4)
    assert within(bounds, 9.0, 9.0) == pytest.approx(V_MAX * unit(np.pi / 4))
    assert within(bounds, 9.0, 0.0) == pytest.approx((SQRT2 * V_MAX, 0.0))
    assert within(bounds, 0.0, -9.0) == pytest.approx((0.0, -SQRT2 * V_MAX))
    assert BOX.fastest == pytest.approx(SQRT2 * V_MAX)
    assert room_along(bounds, 0.1, 0.0, 1.0, 0.0) == pytest.approx(SQRT2 * V_MAX - 0.1)
    assert room_along(bounds, 2.0, 0.0, 1.0, 0.0) == 0.0


@given(place=vectors, yaw=yaws)
def test_no_straight_way_is_faster_than_its_bound(place, yaw):
    problem = problem_over(open_field())
    goal, bounds = problem.constants.goal, velocity_bounds(BOX, yaw)
    away = np.array([goal.x, goal.y]) - place
    real = (np.hypot(*away) - goal.tolerance) / fastest_along(bounds, *away.tolist())
    assert straight_time(goal, bounds, motion_in(problem, (*place, 0.0, 0.0))) <= real + 1e-9


@FEW
@given(yaw=yaws, bearing=yaws, v=vectors, strategy=st.sampled_from(("bounce", "stop_guarantee")))
def test_every_command_of_a_time_to_goal_plan_is_within_the_box(yaw, bearing, v, strategy):
    chosen = SHAPES["box"].with_values({"planner.strategy": strategy})
    state = at_rest(yaw=yaw, velocity=within(velocity_bounds(BOX, yaw), *v.tolist()))
    _, memory = time_to_goal.plan_cycle(None, map_of(TURN, half_side=1.2), state, 2.0 * unit(bearing), chosen)
    assert len(memory.commands) > 5
    assert largest_axis(memory.commands, yaw) <= V_MAX * (1 + 1e-9)


@FEW
@given(yaw=yaws, bearing=yaws, v=vectors)
def test_every_candidate_and_plan_of_the_paper_is_within_the_box(yaw, bearing, v):
    state = at_rest(yaw=yaw, velocity=within(velocity_bounds(BOX, yaw), *v.tolist()))
    plan, _ = paper.plan_cycle(None, map_of(TURN), state, 4.0 * unit(bearing), SHAPES["box"])
    assert largest_axis(plan.candidates.velocities, yaw) <= V_MAX * (1 + 1e-9)
    assert largest_axis(plan.velocities, yaw) <= V_MAX * (1 + 1e-3)


@pytest.mark.parametrize(("strategy", "away"), [("bounce", 3.0), ("avoid", 3.0), ("harness", 0.4)])
def test_along_the_diagonal_of_a_box_a_plan_is_shorter_by_the_root_of_2(strategy, away, monkeypatch):
    monkeypatch.setattr(trajectory, "PEAK", 100.0)
    planner = paper if strategy == "harness" else time_to_goal
    yaw, lasts = np.pi / 4, []
    for shape, most in (("disc", V_MAX), ("box", SQRT2 * V_MAX)):
        chosen = SHAPES[shape].with_values({"planner.strategy": strategy})
        state = at_rest(yaw=yaw, velocity=(0.0, most))
        plan, _ = planner.plan_cycle(None, map_of(world_of()), state, np.array([0.0, away]), chosen)
        lasts.append(plan.times[-1])
    assert lasts[0] / lasts[1] == pytest.approx(SQRT2, rel=0.02)


@given(yaw=yaws, x=st.floats(-1.5, 1.5), y=st.floats(-1.5, 1.5), now=st.floats(0.0, 2.0))
def test_every_command_of_the_controller_is_within_the_box(yaw, x, y, now):
    ways, times = np.array([[0.0, 0.0], [1.0, 1.0], [3.0, 0.5]]), np.array([0.0, 1.0, 2.5])
    plan = timed_path(0.0, times, ways, np.gradient(ways, times, axis=0))
    state = State(now, np.array([x, y]), np.zeros(2), yaw)
    command, _ = follow(ControllerMemory(), plan, map_of(world_of()), state, now, SHAPES["box"])
    assert np.abs(command.velocity).max() <= V_MAX * (1 + 1e-9)


@pytest.mark.parametrize("shape", SHAPES)
def test_by_hand_a_robot_behind_its_path_is_commanded_the_corner_of_the_box(shape):
    plan = timed_path(0.0, np.array([0.0, 4.0]), np.array([[2.0, 0.0], [2.1, 0.0]]), np.zeros((2, 2)))
    state = at_rest(yaw=np.pi / 4)
    command, _ = follow(ControllerMemory(), plan, map_of(world_of()), state, 0.0, SHAPES[shape])
    most = V_MAX if shape == "box" else V_MAX / SQRT2
    assert command.velocity == pytest.approx([most, -most])


def test_what_counts_as_too_fast_grows_with_the_box():
    fast, limits = 1.45 * np.array([V_MAX, V_MAX]), Limits()
    assert clip_command(fast, 0.0, DISC, limits) is None
    clipped, _ = clip_command(fast, 0.0, BOX, limits)
    assert clipped == pytest.approx([V_MAX, V_MAX])
    assert clip_command(1.1 * fast, 0.0, BOX, limits) is None
    gap = 0.1
    after = State(gap, np.full(2, 1.45 * V_MAX * gap), np.zeros(2), 0.0)
    assert [is_relocated(at_rest(), after, robot, limits, 0.0) for robot in (DISC, BOX)] == [True, False]


@pytest.mark.parametrize("shape", SHAPES)
def test_poses_along_the_diagonal_at_full_speed_are_those_of_a_box_alone(shape):
    memory, result = FRESH, None
    for k in range(20):
        sample = PoseSample(0.01 * k, np.full(2, V_MAX * 0.01 * k), 0.0)
        result, memory = filter_pose(memory, sample, sample.stamp, SHAPES[shape])
    if shape == "disc":
        assert result.refused == SPEED
    else:
        assert result.state.velocity == pytest.approx([V_MAX, V_MAX], rel=1e-6)
