"""Rebounds against the closed form, seen from positions alone; normals from shapely."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from omnipuck_sim.robot.rebound import IMPACT_SPEED, Ring, closing_speed, rebound, slide

from collplan_core.parameters import Simulation
from collplan_core.plane import rotate
from physics_scenes import QUIET, RADIUS, RESTITUTION, RETENTION, flight, launched, make_world, quiet, unit

PENTAGON = np.array([[0.30, 0.05], [0.10, 0.35], [-0.28, 0.20], [-0.25, -0.22], [0.12, -0.30]])
CIRCLE = np.array([0.1, -0.2, 0.15])
INCIDENCES = np.radians([-75.0, -60.0, -40.0, -20.0, -5.0, 0.0, 10.0, 30.0, 50.0, 70.0, 78.0])
SPEEDS = (0.1, 0.45, 1.2, 3.6)
NEAR, FAR = 0.005, 0.050


def closed_form(before: np.ndarray, normal: np.ndarray, e: float = RESTITUTION, k: float = RETENTION) -> np.ndarray:
    along = before - (before @ normal) * normal
    return k * along - e * (before @ normal) * normal


def between(times, positions, start, end) -> np.ndarray:
    """Mean velocity between two times, from positions alone."""
    p0, p1 = (np.array([np.interp(t, times, axis) for axis in positions.T]) for t in (start, end))
    return (p1 - p0) / (end - start)


def assert_rebound(geometry, radius, world, touch, normal, speed, incidence):
    """Flies at a disc centre `touch` on contact and compares both sides of the hit with the closed form."""
    velocity = speed * np.array(rotate(*-normal, incidence))
    hit = 0.07
    sim = launched(world, touch - hit * velocity, velocity)
    times, positions, _ = flight(sim, 2 * hit)
    before = between(times, positions, hit - FAR, hit - NEAR)
    after = between(times, positions, hit + NEAR, hit + FAR)
    # the normal as shapely sees it: from the obstacle to the centre at the contact
    at_hit = shapely.Point(touch)
    line = shapely.shortest_line(geometry, at_hit).coords
    seen = np.subtract(line[1], line[0]) / np.hypot(*np.subtract(line[1], line[0]))
    expected = closed_form(before, seen)
    assert np.linalg.norm(after) == pytest.approx(np.linalg.norm(expected), rel=0.02)
    assert after @ expected / np.linalg.norm(after) / np.linalg.norm(expected) > np.cos(np.radians(2.0))
    (impact,) = sim.take_impacts()
    assert impact.time == pytest.approx(hit, abs=2e-4)
    assert impact.normal == pytest.approx(seen, abs=1e-3)
    assert geometry.distance(shapely.Point(impact.point)) == pytest.approx(RADIUS - radius, abs=1e-5)
    assert impact.velocity_before == pytest.approx(velocity)
    assert impact.velocity_after == pytest.approx(closed_form(velocity, seen), abs=2e-3)


def hits(speed, incidence) -> bool:
    return speed * np.cos(incidence) > IMPACT_SPEED


@pytest.mark.parametrize("face", range(len(PENTAGON)))
@pytest.mark.parametrize("speed", SPEEDS)
def test_faces_give_the_closed_form(face, speed):
    a, b = PENTAGON[face], PENTAGON[(face + 1) % len(PENTAGON)]
    edge = (b - a) / np.linalg.norm(b - a)
    normal = np.array([edge[1], -edge[0]])
    for incidence in filter(lambda i: hits(speed, i), INCIDENCES):
        touch = 0.5 * (a + b) + RADIUS * normal
        assert_rebound(shapely.Polygon(PENTAGON), RADIUS, make_world([PENTAGON]), touch, normal, speed, incidence)


@pytest.mark.parametrize("speed", SPEEDS)
def test_corners_of_a_polygon_give_the_closed_form(speed):
    normal = unit(0.15)
    touch = PENTAGON[0] + RADIUS * normal
    for incidence in filter(lambda i: hits(speed, i), INCIDENCES):
        assert_rebound(shapely.Polygon(PENTAGON), RADIUS, make_world([PENTAGON]), touch, normal, speed, incidence)


@pytest.mark.parametrize("where", np.radians([-130.0, 5.0, 90.0]))
@pytest.mark.parametrize("speed", SPEEDS)
def test_circles_give_the_closed_form(where, speed):
    normal = unit(where)
    touch = CIRCLE[:2] + (CIRCLE[2] + RADIUS) * normal
    centre = shapely.Point(CIRCLE[:2])
    for incidence in filter(lambda i: hits(speed, i), INCIDENCES):
        assert_rebound(centre, RADIUS - CIRCLE[2], make_world(circles=[CIRCLE]), touch, normal, speed, incidence)


def test_walls_of_a_walled_world_throw_back():
    sim = launched(make_world(walled=True, bounds=(0.0, 0.0, 2.0, 2.0)), (1.0, 1.0), (1.0, 0.5))
    flight(sim, 1.2)
    (impact,) = sim.take_impacts()
    assert impact.point == pytest.approx([2.0, 1.455], abs=1e-5)
    assert impact.velocity_after == pytest.approx([-RESTITUTION, RETENTION * 0.5])


vectors = st.tuples(st.floats(-5, 5), st.floats(-5, 5))


@settings(derandomize=True, deadline=None, max_examples=100)
@given(vectors, st.floats(-np.pi, np.pi), st.floats(0, 1), st.floats(0, 1))
def test_rebound_leaves_the_wall_and_gains_nothing(velocity, angle, e, k):
    normal = tuple(unit(angle))
    into = closing_speed(velocity, normal)
    after = rebound(velocity, normal, e, k)
    assert closing_speed(after, normal) == pytest.approx(-e * into, abs=1e-12)
    assert np.hypot(*after) <= np.hypot(*velocity) + 1e-12
    assert after == pytest.approx(tuple(closed_form(np.array(velocity), np.array(normal), e, k)))


@settings(derandomize=True, deadline=None, max_examples=100)
@given(vectors, st.floats(-np.pi, np.pi))
def test_sliding_takes_off_only_what_leads_into_the_wall(velocity, angle):
    normal = unit(angle)
    along = np.array(velocity) - (np.array(velocity) @ normal) * normal
    after = np.array(slide(velocity, tuple(normal)))
    assert after == pytest.approx(along + max(np.array(velocity) @ normal, 0.0) * normal)


def test_a_wide_spread_never_throws_into_the_wall():
    ring = Ring(Simulation(direction_spread=0.5), np.random.default_rng(0))
    velocity, normal = (1.2, -0.1), (0.0, 1.0)
    thrown = np.array([ring.velocity_after(velocity, normal) for _ in range(100)])
    assert (thrown[:, 1] >= 0.0).all()
    assert (thrown[:, 1] == 0.0).any()
    assert (np.hypot(*thrown.T) <= np.hypot(*velocity)).all()


@pytest.mark.parametrize("speed", [0.3, 1.2])
def test_spread_stays_within_its_bounds_and_never_gains(speed):
    config = quiet(restitution_spread=0.3, direction_spread=0.3)
    world = make_world([[(0.0, -1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 1.0)]])
    speeds, angles = [], []
    for seed in range(60):
        sim = launched(world, (-0.2, 0.0), (speed, 0.0), config, seed)
        flight(sim, 0.5)
        (impact,) = sim.take_impacts()
        speeds.append(np.linalg.norm(impact.velocity_after) / speed)
        angles.append(np.arctan2(impact.velocity_after[1], -impact.velocity_after[0]))
    assert RESTITUTION - 0.3 <= min(speeds) < 0.5
    assert 0.9 < max(speeds) <= 1.0
    assert -0.3 <= min(angles) < -0.2
    assert 0.2 < max(angles) <= 0.3


def test_slow_contact_slides_and_is_no_impact():
    """2 degrees at v_max: 0.042 m/s into the wall."""
    world = make_world([[(-3.0, -1.0), (3.0, -1.0), (3.0, 0.0), (-3.0, 0.0)]])
    sim = launched(world, (0.0, RADIUS + 0.01), QUIET.robot.max_speed * unit(np.radians(-2.0)))
    _, positions, velocities = flight(sim, 1.0)
    assert sim.take_impacts() == []
    assert velocities[-1] == pytest.approx([QUIET.robot.max_speed * np.cos(np.radians(2.0)), 0.0], abs=1e-12)
    assert positions[-1][1] == pytest.approx(RADIUS, abs=1e-5)
