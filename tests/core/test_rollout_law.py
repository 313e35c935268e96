"""One step of the robot's law: the wheels, the first contact in it, and what contacts and grazes cost."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.reflection import rebound
from collplan_core.time_to_goal_planner.boundary_memory.clearance import INFERRED, OBSERVED, clearance_at
from collplan_core.time_to_goal_planner.dynamics import NO_CONTACT, SLIDES, clearance_cost, contact_cost, driven
from collplan_core.time_to_goal_planner.model import IMPACT_SPEED, STEP, Law, law_of, price_of
from rollout_scenes import SETTINGS, faces_field, joined, pillars_field, scene_over, stepped, with_strategy
from scenes import rotation, unit

QUICK = settings(derandomize=True, deadline=None, max_examples=60, print_blob=True)
FEW = settings(derandomize=True, deadline=None, max_examples=15, print_blob=True)
LAW = law_of(with_strategy("bounce"))
SPEED = LAW.max_speed
angles = st.floats(-np.pi, np.pi)
shares = st.floats(0.0, 1.0)
velocities = st.tuples(st.floats(0.0, SPEED), angles).map(lambda v: v[0] * unit(v[1]))
durations = st.floats(0.0, 0.3)
into_wall = st.floats(np.radians(-75.0), np.radians(75.0))
HALF = 0.3
ROOM = scene_over(faces_field(*((k * np.pi / 2, HALF) for k in range(4)), half_side=0.5), (0.0, 0.0))
"""The disc's centre stays within |x|, |y| <= HALF."""


def coasting(restitution: float = LAW.restitution, retention: float = LAW.retention) -> Law:
    """A robot without wheels: nothing but boundaries changes its velocity."""
    return LAW._replace(max_acceleration=1e-15, restitution=restitution, retention=retention)


def after(velocity, command, duration: float, law: Law = LAW) -> np.ndarray:
    return np.array(driven(*map(float, velocity), *map(float, command), duration, law))


@FEW
@given(v=velocities, u=velocities, duration=durations)
def test_the_wheels_follow_their_equation(v, u, duration):
    """dv/dt = sat((u - v) / lag), by a thousand steps of the midpoint rule."""

    def rate(velocity: np.ndarray) -> np.ndarray:
        wanted = (u - velocity) / LAW.lag
        return wanted / max(1.0, np.hypot(*wanted) / LAW.max_acceleration)

    expected, h = v.copy(), duration / 1000
    for _ in range(1000):
        expected = expected + h * rate(expected + 0.5 * h * rate(expected))
    np.testing.assert_allclose(after(v, u, duration), expected, atol=2e-5)


@QUICK
@given(v=velocities, u=velocities, first=durations, second=durations)
def test_driving_on_is_driving_longer(v, u, first, second):
    np.testing.assert_allclose(after(after(v, u, first), u, second), after(v, u, first + second), atol=1e-12)


@QUICK
@given(v=velocities, u=velocities, duration=durations, turn=angles)
def test_the_wheels_never_overshoot_and_know_no_direction(v, u, duration, turn):
    came = after(v, u, duration)
    assert np.hypot(*(came - v)) <= LAW.max_acceleration * duration + 1e-12
    assert np.hypot(*(came - v)) + np.hypot(*(u - came)) == pytest.approx(np.hypot(*(u - v)), abs=1e-12)
    np.testing.assert_allclose(
        after(rotation(turn) @ v, rotation(turn) @ u, duration), rotation(turn) @ came, atol=1e-12
    )


def test_by_hand_full_acceleration_then_a_first_order_lag():
    np.testing.assert_allclose(after((0.0, 0.0), (1.2, 0.0), STEP), (1.5 * STEP, 0.0), atol=1e-12)
    # 0.15 m/s is what the lag makes of full acceleration: reached after 0.1 s
    np.testing.assert_allclose(after((0.9, 0.0), (1.2, 0.0), 0.2), (1.2 - 0.15 * np.exp(-1.0), 0.0), atol=1e-12)
    np.testing.assert_allclose(after((1.1, 0.0), (1.2, 0.0), STEP), (1.2 - 0.1 * np.exp(-0.25), 0.0), atol=1e-12)


def one_wall(bearing: float, source: int = OBSERVED):
    """A wall that the disc's centre touches at the origin; its normal points along the bearing."""
    return scene_over(faces_field((bearing, 0.0), source=source, half_side=0.3), 0.25 * unit(bearing))


WALLS = [(bearing, one_wall(bearing)) for bearing in (0.0, 0.37, np.pi / 2, 2.5, -1.2)]
walls = st.sampled_from(WALLS)


def at_wall(bearing: float, incidence: float, speed: float, share: float) -> np.ndarray:
    """A state that touches the wall after a share of a step."""
    velocity = speed * (rotation(incidence) @ -unit(bearing))
    return np.array([*(-share * STEP * velocity), *velocity])


@QUICK
@given(wall=walls, incidence=into_wall, speed=st.floats(0.4, SPEED), share=st.floats(0.0, 0.95), e=shares, k=shares)
def test_a_contact_is_the_rebound_and_the_rest_of_the_step_goes_on_from_it(wall, incidence, speed, share, e, k):
    bearing, scene = wall
    begin = at_wall(bearing, incidence, speed, share)
    (row,) = stepped(scene, coasting(e, k), begin, [(0.0, 0.0)])
    expected = rebound(begin[2:], unit(bearing), e, k)
    assert row[5] == OBSERVED
    assert row[6] == pytest.approx(speed * np.cos(incidence), abs=1e-9)
    assert row[7] == pytest.approx(share, abs=2e-2 if share < 0.05 else 1e-9)
    np.testing.assert_allclose(row[8:], unit(bearing), atol=1e-9)
    np.testing.assert_allclose(row[2:4], expected, atol=1e-9)
    np.testing.assert_allclose(row[:2], (1.0 - row[7]) * STEP * expected, atol=5e-4)


@QUICK
@given(wall=walls, incidence=into_wall, speed=st.floats(0.4, SPEED), share=st.floats(0.05, 0.95))
def test_a_perfect_rebound_keeps_the_speed_and_drives_the_mirrored_path(wall, incidence, speed, share):
    bearing, scene = wall
    begin, normal = at_wall(bearing, incidence, speed, share), unit(bearing)
    (row,) = stepped(scene, coasting(1.0, 1.0), begin, [(0.0, 0.0)])
    onward = begin[:2] + STEP * begin[2:]
    assert np.hypot(*row[2:4]) == pytest.approx(speed, abs=1e-12)
    np.testing.assert_allclose(row[:2], onward - 2.0 * (onward @ normal) * normal, atol=1e-9)


@QUICK
@given(wall=walls, incidence=into_wall, speed=st.floats(0.0, SPEED), share=shares, u=velocities, mirrored=st.booleans())
def test_a_step_turns_and_mirrors_with_the_wall(wall, incidence, speed, share, u, mirrored):
    bearing, scene = wall
    plain = WALLS[0][1]
    move = rotation(bearing) @ np.diag([1.0, -1.0 if mirrored else 1.0])
    # a little before the wall: rounding must not decide whether it is touched
    begin = at_wall(0.0, incidence, speed, share) + np.array([1e-5, 0.0, 0.0, 0.0])
    (one,) = stepped(plain, LAW, begin, [u])
    (other,) = stepped(scene, LAW, [*(move @ begin[:2]), *(move @ begin[2:])], [move @ u])
    for pair in (slice(0, 2), slice(2, 4), slice(8, 10)):
        np.testing.assert_allclose(other[pair], move @ one[pair], atol=1e-7)
    assert other[5] == one[5]
    np.testing.assert_allclose(other[6:8], one[6:8], atol=1e-5)


commands = st.lists(st.tuples(velocities, st.integers(1, 12)), min_size=3, max_size=8).map(
    lambda parts: np.repeat([u for u, _ in parts], [count for _, count in parts], axis=0)
)
places = st.tuples(st.floats(-HALF, HALF), st.floats(-HALF, HALF))


@FEW
@given(begin=places, v=velocities, u=commands, e=shares, k=shares)
def test_no_contact_gives_energy_and_none_leads_through_a_wall(begin, v, u, e, k):
    rows = stepped(ROOM, LAW._replace(restitution=e, retention=k), [*begin, *v], u)
    before = np.vstack([v, rows[:-1, 2:4]])
    # a driven step ends between the velocity it has and the commanded one
    assert (np.hypot(*rows[:, 2:4].T) <= np.maximum(np.hypot(*before.T), np.hypot(*u.T)) + 1e-9).all()
    assert np.abs(rows[:, :2]).max() <= HALF + 1e-9
    hit = np.isin(rows[:, 5], (OBSERVED, INFERRED))
    assert (rows[hit, 6] > IMPACT_SPEED).all()
    assert (rows[rows[:, 5] == SLIDES, 6] <= IMPACT_SPEED).all()
    assert (rows[rows[:, 5] == NO_CONTACT, 6:] == 0.0).all()


@FEW
@given(begin=places, v=velocities, e=shares, k=shares)
def test_a_coasting_robot_only_loses_speed(begin, v, e, k):
    speeds = np.hypot(*stepped(ROOM, coasting(e, k), [*begin, *v], np.zeros((60, 2)))[:, 2:4].T)
    assert (np.diff(speeds, prepend=np.hypot(*v)) <= 1e-12).all()


CLUTTER = scene_over(
    joined(
        faces_field((0.0, 0.8), (np.pi / 2, 0.8), (np.pi, 0.8), (-np.pi / 2, 0.8), half_side=1.0),
        pillars_field((0.3, 0.3, 0.12), (-0.3, 0.25, 0.05), (0.1, -0.45, 0.2), half_side=1.0),
    ),
    (0.7, 0.7),
)


@FEW
@given(v=velocities, u=commands)
def test_what_is_said_of_the_clearance_is_never_too_much(v, u):
    rows = stepped(CLUTTER, LAW, [-0.05, 0.0, *v], u)
    grid = CLUTTER.grid
    there = [clearance_at(CLUTTER.clearance, grid.ox, grid.oy, grid.spacing, x, y) for x, y in rows[:, :2]]
    assert min(there) > -1e-3
    assert (rows[:, 4] <= np.array(there) + 1e-3).all()
    free = rows[:, 5] == NO_CONTACT
    assert (rows[free, 4] <= np.array(there)[free] + 1e-9).all()


def test_a_slow_contact_slides_and_keeps_the_speed_along_the_wall():
    begin = [0.0005, 0.0, -0.9 * IMPACT_SPEED, 0.5]
    (row,) = stepped(WALLS[0][1], coasting(), begin, [(0.0, 0.0)])
    assert row[5] == SLIDES
    np.testing.assert_allclose(row[2:4], (0.0, 0.5), atol=1e-9)
    (row,) = stepped(WALLS[0][1], coasting(), [0.0005, 0.0, -1.1 * IMPACT_SPEED, 0.5], [(0.0, 0.0)])
    assert row[5] == OBSERVED


def test_pressed_against_a_wall_the_robot_slides_along_it():
    rows = stepped(WALLS[0][1], LAW, [0.0, -0.2, 0.0, 0.3], np.tile((-1.0, 0.3), (30, 1)))
    assert (rows[:, 5] == SLIDES).all()
    np.testing.assert_allclose(rows[:, 0], 0.0, atol=1e-9)
    np.testing.assert_allclose(rows[:, 2], 0.0, atol=1e-9)
    # the wheels push with all they have against the wall: what is left drives along it
    assert (rows[:, 3] > 0.25).all()


def test_inferred_solid_takes_the_speed_into_it():
    scene = one_wall(0.0, INFERRED)
    (row,) = stepped(scene, coasting(), at_wall(0.0, 0.5, 1.0, 0.5), [(0.0, 0.0)])
    assert row[5] == INFERRED
    np.testing.assert_allclose(row[2:4], rebound(np.array([-np.cos(0.5), -np.sin(0.5)]), unit(0.0), 0.0, LAW.retention))


@pytest.mark.parametrize("deep", [0.001, 0.01, 0.04, 0.08])
@pytest.mark.parametrize("velocity", [(0.0, 0.0), (-1.2, 0.0), (1.2, 0.0), (0.0, 1.0)])
def test_from_inside_a_wall_the_robot_comes_out_at_once(deep, velocity):
    (row,) = stepped(WALLS[0][1], LAW, [-deep, 0.0, *velocity], [(0.0, 0.0)])
    assert np.isfinite(row).all()
    assert row[0] >= -1e-9
    assert row[2] >= 0.0


def test_what_a_contact_costs():
    bounce, tolerate, avoid = (price_of(with_strategy(name)) for name in ("bounce", "tolerate", "avoid"))
    p = SETTINGS.time_to_goal
    assert contact_cost(bounce, OBSERVED, 1.0) == pytest.approx(p.hit_cost)
    assert contact_cost(bounce, OBSERVED, p.speed_limit + 0.01) > p.limit_cost
    assert contact_cost(tolerate, OBSERVED, 1.0) == 0.0
    assert contact_cost(avoid, OBSERVED, 0.5) == pytest.approx(p.averse_cost + 0.5 * p.averse_speed_cost)
    assert (
        contact_cost(bounce, INFERRED, 1.0) == contact_cost(tolerate, INFERRED, 1.0) == pytest.approx(p.inferred_cost)
    )
    assert contact_cost(avoid, INFERRED, 0.5) == contact_cost(avoid, OBSERVED, 0.5)
    for price in (bounce, tolerate, avoid):
        assert contact_cost(price, SLIDES, 0.05) == contact_cost(price, NO_CONTACT, 0.0) == 0.0


@QUICK
@given(first=st.floats(IMPACT_SPEED, 2.0), second=st.floats(IMPACT_SPEED, 2.0))
@pytest.mark.parametrize("strategy", ["bounce", "tolerate", "avoid", "stop_guarantee"])
def test_a_harder_contact_never_costs_less(strategy, first, second):
    price = price_of(with_strategy(strategy))
    slow, fast = sorted((first, second))
    for kind in (OBSERVED, INFERRED):
        assert 0.0 <= contact_cost(price, kind, slow) <= contact_cost(price, kind, fast)


PRICE = price_of(with_strategy("bounce"))
POST = scene_over(pillars_field((0.0, 0.0, 0.05), half_side=0.5), (0.4, 0.4))
"""The disc's centre touches the post 0.14 m from the origin."""


def graze(scene, begin, end, speed: float = 1.0) -> float:
    return clearance_cost(scene.clearance, scene.grid, PRICE, *map(float, begin), *map(float, end), speed)


def test_by_hand_what_grazing_a_post_costs():
    # 5 mm beside the post; 2 cm to the right it is met where its normal is 33 degrees off straight back
    met = np.array([-0.1, 0.085])
    cost = PRICE.clearance * 0.1 / np.hypot(*met)
    assert graze(POST, (-0.15, 0.105), (-0.1, 0.105)) == pytest.approx(cost, rel=0.1)
    assert graze(POST, (-0.15, 0.105), (-0.1, 0.105), 0.5) == pytest.approx(0.5 * cost, rel=0.1)
    assert graze(POST, (-0.15, 0.13), (-0.1, 0.13)) == 0.0  # farther beside it than the error that is reckoned with
    assert graze(POST, (-0.05, 0.145), (0.0, 0.145)) == 0.0  # along it
    assert graze(POST, (-0.2, 0.0), (-0.15, 0.0)) == 0.0  # straight at it, and not there yet


def test_by_hand_a_wall_that_is_followed_costs_nothing():
    wall = WALLS[0][1]
    assert graze(wall, (0.01, -0.05), (0.01, 0.0)) == 0.0
    assert graze(wall, (0.05, 0.0), (0.05, 0.0)) == 0.0


nearby = st.tuples(st.floats(0.001, 0.06), st.floats(-0.15, 0.15)).map(np.array)


@QUICK
@given(wall=walls, begin=nearby, angle=angles, length=st.floats(0.001, 0.06), mirrored=st.booleans())
def test_a_graze_is_bounded_and_free_far_from_walls_and_turns_and_mirrors(wall, begin, angle, length, mirrored):
    bearing, scene = wall
    move = rotation(bearing) @ np.diag([1.0, -1.0 if mirrored else 1.0])
    end = begin + length * unit(angle)
    cost = graze(WALLS[0][1], begin, end)
    assert 0.0 <= cost <= 2.0 * PRICE.clearance
    if end[0] > PRICE.distance:
        assert cost == 0.0
    # not where rounding decides whether a shifted end is inside
    shifts = np.add.outer([begin[0], end[0]], PRICE.distance * np.array([-1.0, 1.0]) * np.sin(angle))
    if np.abs(shifts).min() > 1e-6 and abs(-np.cos(angle) - 0.3) > 1e-6:
        assert graze(scene, move @ begin, move @ end) == pytest.approx(cost, abs=1e-9)
