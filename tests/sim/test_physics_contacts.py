"""Grazing, chains, wedges, clutter: no double hit, no sticking, no tunnelling, no energy from nowhere."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from omnipuck_sim.robot.disc import SAME_CONTACT, SLOP
from omnipuck_sim.robot.impact import IMPACT_SPEED
from omnipuck_sim.robot.physics import Simulator
from physics_scenes import FRICTION, QUIET, RADIUS, RESTITUTION, energy_of, flight, launched, make_world, quiet, unit

V_MAX = QUIET.robot.max_speed
STEPS = round(QUIET.simulator.physics_rate)
FLOOR = [(-5.0, -1.0), (5.0, -1.0), (5.0, 0.0), (-5.0, 0.0)]
BALL = 0.075
CHAIN = np.array([(2 * BALL * i - 2.1, -BALL, BALL) for i in range(29)])


def overlap(speed: float) -> float:
    """How deep a disc of this speed may be inside a wall at the end of a step [m]: its travel in one, and the slop."""
    return speed / QUIET.simulator.physics_rate + SLOP + 1e-6


def solid(world) -> shapely.Geometry:
    shapes = [shapely.Polygon(p) for p in world.polygons]
    if world.walled:
        shapes.append(shapely.box(*world.bounds).exterior)
    return shapely.union_all(shapes)


def room(world, positions) -> np.ndarray:
    """Distance of the disc from everything solid at each position (n, 2)."""
    points = shapely.points(positions)
    distances = [shapely.distance(solid(world), points)] if world.polygons or world.walled else []
    distances += [np.hypot(*(positions - c[:2]).T) - c[2] for c in world.circles]
    return np.min(distances, axis=0) - RADIUS


def assert_counted_once(impacts) -> None:
    """On one surface, which here is what lies within a robot's size."""
    for a, b in pairwise(impacts):
        same = np.linalg.norm(a.point - b.point) < RADIUS and a.normal @ b.normal > 0.5
        assert not same or b.time - a.time > SAME_CONTACT


@pytest.mark.parametrize("angle", np.radians([2.0, 3.0, 4.0, 6.0, 8.0, 10.0]))
@pytest.mark.parametrize("speed", [0.3, 1.2, 3.6])
def test_grazing_hits_once_and_goes_on(angle, speed):
    world = make_world([FLOOR])
    velocity = speed * unit(-angle)
    sim = launched(world, np.array([-2.0, RADIUS]) - 0.1 * velocity, velocity)
    _, positions, velocities = flight(sim, 1.0)
    impacts = sim.take_impacts()
    assert len(impacts) == (speed * np.sin(angle) > IMPACT_SPEED)
    into = speed * np.sin(angle)
    assert velocities[-1][0] >= speed * np.cos(angle) - FRICTION * (1 + RESTITUTION) * into - 1e-9
    assert velocities[-1][1] >= 0.0
    assert room(world, positions).min() >= -overlap(into)


@pytest.mark.parametrize("angle", np.radians([2.0, 10.0, 30.0, 60.0]))
def test_pressing_along_a_wall_slides_on(angle):
    sim = Simulator(make_world([FLOOR]), QUIET, 0, start=np.array([-2.0, RADIUS + 1e-5]))
    for _ in range(STEPS * 2):
        sim.command(0.8 * unit(-angle - sim.state.yaw), -2.0 * sim.state.yaw)
        sim.step()
    # friction takes mu of what presses it on, at most a_max
    drag = FRICTION * np.tan(angle) if angle < 1.0 else 0.4
    assert 0.8 * np.cos(angle) * (1 - drag) - 0.03 <= sim.state.velocity[0] <= 0.8 * np.cos(angle) + 0.01
    assert sim.state.position[1] == pytest.approx(RADIUS, abs=1e-3)


@pytest.mark.parametrize("angle", np.radians([0.0, 2.0, 10.0, 30.0]))
def test_pressing_along_a_chain_of_circles_keeps_moving(angle):
    world = make_world(circles=CHAIN)
    sim = Simulator(world, QUIET, 0, start=np.array([-1.9, RADIUS + 0.01]))
    positions = []
    for _ in range(STEPS * 4):
        sim.command(0.6 * unit(-angle - sim.state.yaw), -2.0 * sim.state.yaw)
        sim.step()
        positions.append(sim.state.position)
    progress = np.diff(np.array(positions)[::STEPS, 0])
    assert progress.min() > 0.1
    assert room(world, np.array(positions)).min() >= -overlap(V_MAX)
    assert_counted_once(sim.take_impacts())


@pytest.mark.parametrize("angle", np.radians([2.0, 5.0, 10.0, 45.0, 90.0]))
@pytest.mark.parametrize("offset", [0.0, 0.02, BALL])
def test_a_chain_of_circles_throws_back_once(angle, offset):
    """Also into the notch between two of them, which the robot meets at the same instant."""
    world = make_world(circles=CHAIN)
    # from just above the circles down to a centimetre below their tops
    start = np.array([offset, RADIUS - 0.01]) - 0.011 / np.sin(angle) * unit(-angle)
    sim = launched(world, start, V_MAX * unit(-angle))
    _, positions, velocities = flight(sim, 0.5)
    impacts = sim.take_impacts()
    assert 1 <= len(impacts) <= 3
    assert_counted_once(impacts)
    assert room(world, positions).min() >= -overlap(V_MAX)
    assert np.linalg.norm(velocities[-1]) > 0.2


def test_the_notch_between_two_circles_counts_once():
    """With little restitution one circle throws it onto the other; the chain is one surface."""
    start, config = (BALL + 0.001, RADIUS + 0.05), quiet(restitution=0.2, physics_rate=2000.0)
    sim = launched(make_world(circles=CHAIN), start, (0.0, -V_MAX), config)
    _, _, velocities = flight(sim, 0.2)
    changes = np.linalg.norm(np.diff(velocities, axis=0), axis=1)
    assert (changes > 0.1).sum() >= 2
    assert len(sim.take_impacts()) == 1


@pytest.mark.parametrize("half_angle", np.radians([10.0, 20.0, 45.0, 80.0]))
@pytest.mark.parametrize("speed", [0.4, 3.6])
def test_a_wedge_does_not_hold_the_robot(half_angle, speed):
    """Thrown and then pressed into it for a second, it drives out freely."""
    upper = np.array([(0.0, 0.0), 2 * unit(half_angle), 2 * unit(half_angle + 0.1)])
    world = make_world([upper, upper * [1, -1]])
    sim = launched(world, (1.0, 0.0), (-speed, 0.003))
    _, positions, _ = flight(sim, 1.0)
    assert room(world, positions).min() >= -2 * overlap(speed)
    sim.drive = True
    for direction in (-1.0, 1.0):
        deepest = sim.state.position[0]
        for _ in range(2 * STEPS):
            sim.command(0.8 * direction * unit(-sim.state.yaw), -2.0 * sim.state.yaw)
            sim.step()
    assert sim.state.position[0] > deepest + 0.3


@pytest.mark.parametrize("shift", np.linspace(0.0, 3 * V_MAX / 400, 7))
def test_nothing_tunnels_at_three_times_full_speed(shift):
    """A wall of 1 mm and a pole of 1 mm, at the slowest physics rate."""
    wall = [(1.0, -1.0), (1.001, -1.0), (1.001, 1.0), (1.0, 1.0)]
    world = make_world([wall], circles=[(-1.0, 0.0, 0.001)])
    for sign in (1.0, -1.0):
        sim = launched(world, (shift, 0.0), (sign * 3 * V_MAX, 0.0), quiet(physics_rate=400.0))
        _, positions, velocities = flight(sim, 0.4)
        assert np.abs(positions[:, 0]).max() <= 1.0 - RADIUS + 3 * V_MAX / 400 + SLOP
        assert velocities[-1] == pytest.approx([-RESTITUTION * sign * 3 * V_MAX, 0.0], abs=1e-6)


CLUTTER = make_world(
    polygons=[
        [(0.9, 0.9), (1.4, 1.0), (1.1, 1.5)],
        [(0.3, 1.4), (0.7, 1.5), (0.6, 1.9), (0.25, 1.8)],
        [(1.4, 0.0), (1.7, 0.0), (1.55, 0.5)],
    ],
    circles=[(0.9 + 2 * BALL * i, 2.0, BALL) for i in range(6)] + [(0.4, 0.75, 0.2)],
    walled=True,
    bounds=(0.0, 0.0, 2.2, 2.2),
)


def check_free_flight(seed: int, direction: float, speed: float, duration: float) -> None:
    config = quiet(restitution_spread=0.2, friction_spread=0.1, wall_spread=0.2)
    sim = launched(CLUTTER, (0.8, 0.4), speed * unit(direction), config, seed)
    positions, energies = [], [energy_of(sim)]
    for _ in range(round(duration * STEPS)):
        sim.step()
        positions.append(sim.state.position)
        energies.append(energy_of(sim))
    assert room(CLUTTER, np.array(positions)).min() >= -2 * overlap(speed)
    assert (np.diff(energies) <= 1e-9 * energies[0] + 1e-12).all()
    for impact in sim.take_impacts():
        assert impact.velocity_before @ impact.normal < 0.0


flights = (st.integers(0, 2**31 - 1), st.floats(-np.pi, np.pi), st.floats(0.05, 3 * V_MAX))


@settings(derandomize=True, deadline=None, max_examples=40)
@given(*flights)
def test_free_flight_stays_outside_and_never_gains(seed, direction, speed):
    check_free_flight(seed, direction, speed, duration=2.0)


@pytest.mark.soak
@settings(derandomize=True, deadline=None, max_examples=800)
@given(*flights)
def test_free_flight_stays_outside_and_never_gains_long(seed, direction, speed):
    check_free_flight(seed, direction, speed, duration=6.0)


@settings(derandomize=True, deadline=None, max_examples=15)
@given(st.integers(0, 2**31 - 1))
def test_driven_at_random_it_stays_outside_and_unstuck(seed):
    sim = Simulator(CLUTTER, QUIET, seed, start=np.array([0.8, 0.4]))
    random = np.random.default_rng(seed)
    positions = []
    for _ in range(30):
        velocity = V_MAX * unit(random.uniform(-np.pi, np.pi))
        for k in range(200):
            if k % 50 == 0:
                sim.command(velocity, 0.0)
            sim.step()
            positions.append(sim.state.position)
    assert room(CLUTTER, np.array(positions)).min() >= -2 * overlap(V_MAX)
    assert np.linalg.norm(np.diff(np.array(positions)[::400], axis=0), axis=1).max() > 0.1
