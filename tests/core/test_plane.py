"""Rotation, the nearest point of a segment, the rebound of the disc, and the robot's velocity law."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Point

from collplan_core.parameters import Robot, Settings
from collplan_core.plane import nearest_on_segment, rotate, rotate_rows
from collplan_core.reflection import Ring, believed_ring, rebound, reflect
from collplan_core.velocity_law import SHORTEST_LAG, command_lead, velocity_after, velocity_law
from scenes import rotation, unit

# shapely cannot measure segments shorter than 1e-300
numbers = st.floats(-10.0, 10.0).map(lambda number: round(number, 9))


@given(numbers, numbers, numbers)
def test_a_rotation_is_that_of_the_matrix_and_rows_turn_like_single_vectors(x, y, angle):
    assert rotate(x, y, angle) == pytest.approx(rotation(angle) @ (x, y), abs=1e-12)
    rows = np.array([[x, y], [1.0, 2.0]])
    expected = [rotate(x, y, angle), rotate(1.0, 2.0, -angle)]
    np.testing.assert_allclose(rotate_rows(rows, np.array([angle, -angle])), expected, atol=1e-12)
    np.testing.assert_allclose(rotate_rows(rows, angle)[:1], expected[:1], atol=1e-12)


@given(numbers, numbers, numbers, numbers, numbers, numbers)
def test_nothing_of_a_segment_is_nearer_than_its_nearest_point(ax, ay, bx, by, x, y):
    px, py = nearest_on_segment(ax, ay, bx, by, x, y)
    segment = LineString([(ax, ay), (bx, by)])
    assert segment.distance(Point(px, py)) < 1e-7
    assert math.hypot(px - x, py - y) == pytest.approx(segment.distance(Point(x, y)), abs=1e-7)
    assert nearest_on_segment(ax, ay, ax, ay, x, y) == (ax, ay)


velocities = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)).map(np.array)
angles = st.floats(-np.pi, np.pi)
shares = st.floats(0.0, 1.0)
rims = st.floats(-1.0, 1.0)
rings = st.builds(Ring, shares, st.floats(0.0, 2.0), st.floats(0.05, 0.5), st.just(1.0))
SHIPPED = Ring(0.7, 0.12, 1.0 / 3.0)


def parts(v, rim, normal, ring):
    """Speed out of the boundary, along it, and that of the rim by spin, after a hit; and how the rim slips then."""
    vx, vy, after = reflect(*v, rim, *normal, ring)
    tangent = rotation(np.pi / 2) @ normal
    along = np.array([vx, vy]) @ tangent
    return np.array([vx, vy]) @ normal, along, after, along - after


def incoming(v, normal):
    return normal if v @ normal <= 0.0 else -normal


def energy(v, rim, ring):
    """Twice the energy over the mass; I / r^2 = m f / (1 - f)."""
    return v[0] ** 2 + v[1] ** 2 + ring.inertia_factor / (1.0 - ring.inertia_factor) * rim**2


@given(v=velocities, rim=rims, normal=angles.map(unit), ring=rings)
def test_energy_never_grows_and_the_speed_into_the_boundary_comes_back_by_its_share(v, rim, normal, ring):
    after = reflect(*v, rim, *normal, ring)
    assert energy(after[:2], after[2], ring) <= energy(v, rim, ring) * (1 + 1e-12) + 1e-15
    assert np.array(after[:2]) @ normal == pytest.approx(-ring.restitution * (v @ normal), abs=1e-12)


@given(v=velocities, rim=rims, normal=angles.map(unit), ring=rings)
def test_friction_opposes_the_slip_stays_within_the_cone_and_at_most_stops_it(v, rim, normal, ring):
    normal = incoming(v, normal)
    tangent = rotation(np.pi / 2) @ normal
    _, along, _, slip_after = parts(v, rim, normal, ring)
    slip, change = v @ tangent - rim, along - v @ tangent
    assert change * slip <= 1e-12
    assert abs(change) <= ring.friction * (1.0 + ring.restitution) * abs(v @ normal) + 1e-12
    assert slip_after * slip >= -1e-9
    assert abs(slip_after) <= abs(slip) + 1e-12


@given(v=velocities, rim=rims, normal=angles.map(unit), ring=rings)
def test_the_angular_momentum_about_the_point_touched_stays(v, rim, normal, ring):
    normal = incoming(v, normal)
    tangent = rotation(np.pi / 2) @ normal
    _, along, after, _ = parts(v, rim, normal, ring)
    share = ring.inertia_factor / (1.0 - ring.inertia_factor)
    assert along + share * after == pytest.approx(v @ tangent + share * rim, abs=1e-11)


@given(v=velocities, normal=angles.map(unit), ring=rings, share=st.floats(0.1, 1.0))
def test_wheels_that_a_hit_does_not_stop_take_a_share_of_its_change(v, normal, ring, share):
    change = rebound(v, normal, ring) - v
    np.testing.assert_allclose(rebound(v, normal, ring._replace(body_share=share)), v + share * change, atol=1e-12)


def test_by_hand_a_wall_below():
    for v, rim, after in [
        # it slides: 0.12 * 1.7 of the speed into the wall is taken from that along it, and spins it by twice that
        ((1.0, -1.0), 0.0, (0.796, 0.7, -0.408)),
        ((-1.0, -1.0), 0.0, (-0.796, 0.7, 0.408)),
        # steep: it grips, a third of the slip is taken
        ((0.3, -1.0), 0.0, (0.2, 0.7, -0.2)),
        ((0.0, -1.0), 0.0, (0.0, 0.7, 0.0)),
        ((1.0, 0.0), 0.0, (1.0, 0.0, 0.0)),
        # clockwise spin alone drives it along the wall; it rolls where the rim is as fast as the centre
        ((0.0, -1.0), -0.3, (0.1, 0.7, -0.1)),
        ((0.5, -1.0), -0.5, (0.5, 0.7, -0.5)),
    ]:
        np.testing.assert_allclose(reflect(*v, rim, 0.0, 1.0, SHIPPED), after, atol=1e-12)


def test_wheels_half_as_heavy_as_the_body_take_a_third():
    assert believed_ring(Settings(robot=Robot(mass=0.7, wheel_mass=0.35))).body_share == pytest.approx(2.0 / 3.0)
    assert believed_ring(Settings()).body_share == 1.0


FEW = settings(max_examples=15)
STEP = 0.025
ROBOT = Robot()
LAW = velocity_law(ROBOT, STEP)
SPEED = ROBOT.max_speed
of_the_robot = st.tuples(st.floats(0.0, SPEED), angles).map(lambda v: v[0] * unit(v[1]))
durations = st.floats(0.0, 0.3)


def after(velocity, command, duration: float, law=LAW) -> np.ndarray:
    return np.array(velocity_after(law, *map(float, velocity), *map(float, command), duration))


@FEW
@given(v=of_the_robot, u=of_the_robot, duration=durations)
def test_the_wheels_follow_their_equation(v, u, duration):
    """dv/dt = sat((u - v) / lag), by a thousand steps of the midpoint rule."""

    def rate(velocity: np.ndarray) -> np.ndarray:
        wanted = (u - velocity) / LAW.lag
        return wanted / max(1.0, np.hypot(*wanted) / LAW.max_acceleration)

    expected, h = v.copy(), duration / 1000
    for _ in range(1000):
        expected = expected + h * rate(expected + 0.5 * h * rate(expected))
    np.testing.assert_allclose(after(v, u, duration), expected, atol=2e-5)
    # the step that is quick changes nothing
    np.testing.assert_allclose(after(v, u, STEP, velocity_law(ROBOT)), after(v, u, STEP), atol=1e-15)


@given(v=of_the_robot, u=of_the_robot, duration=durations, turn=angles)
def test_the_wheels_never_overshoot_and_have_no_direction(v, u, duration, turn):
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
    # no lag at all is a very short one
    law = velocity_law(Robot(velocity_lag=0.0))
    assert law.lag == SHORTEST_LAG
    np.testing.assert_allclose(after((0.0, 0.0), (0.1, 0.0), 0.1, law), (0.1, 0.0), atol=1e-9)


@given(lead=st.floats(1e-3, 2.0), duration=st.floats(0.005, 0.3))
def test_the_lead_is_what_the_command_was_ahead_by(lead, duration):
    """Where the acceleration is full all the time, every larger lead would do: the smallest one is found."""
    change = after((0.0, 0.0), (lead, 0.0), duration)[0]
    found = command_lead(LAW, change, duration)
    assert found <= lead + 1e-5
    np.testing.assert_allclose(after((0.0, 0.0), (found, 0.0), duration)[0], change, atol=1e-5)
