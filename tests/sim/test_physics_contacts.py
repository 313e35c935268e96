"""Grazing, chains, wedges, clutter: no double hit, no sticking, no tunnelling, no energy from nowhere."""

from itertools import pairwise, product

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from omnipuck_sim.robot.disc import SAME_CONTACT, SLOP
from omnipuck_sim.robot.hit_law import IMPACT_SPEED
from physics_scenes import (
    FRICTION,
    QUIET,
    RADIUS,
    RESTITUTION,
    V_MAX,
    energy_of,
    flight,
    launched,
    make_world,
    quiet,
    unit,
)

STEPS = round(QUIET.simulator.physics_rate)
FLOOR = make_world([[(-5.0, -1.0), (5.0, -1.0), (5.0, 0.0), (-5.0, 0.0)]])
BALL = 0.075
CHAIN = make_world(circles=[(2 * BALL * i - 2.1, -BALL, BALL) for i in range(29)])


def overlap(speed: float) -> float:
    """How deep a disc of this speed may be inside a wall at the end of a step [m]: its travel in one, and the slop."""
    return speed / QUIET.simulator.physics_rate + SLOP + 1e-6


def room(world, positions) -> np.ndarray:
    """Distance of the disc from everything solid at each position (n, 2)."""
    shapes = [shapely.Polygon(p) for p in world.polygons]
    shapes += [shapely.box(*world.bounds).exterior] if world.walled else []
    distances = [shapely.distance(shapely.union_all(shapes), shapely.points(positions))] if shapes else []
    distances += [np.hypot(*(positions - c[:2]).T) - c[2] for c in world.circles]
    return np.min(distances, axis=0) - RADIUS


def assert_counted_once(impacts) -> None:
    """On one surface, which here is what lies within a robot's size."""
    for a, b in pairwise(impacts):
        same = np.linalg.norm(a.point - b.point) < RADIUS and a.normal @ b.normal > 0.5
        assert not same or b.time - a.time > SAME_CONTACT


def test_grazing_hits_once_and_goes_on():
    for case in product(np.radians([2.0, 3.0, 4.0, 6.0, 10.0]), (0.3, 1.2, 3.6)):
        angle, speed = case
        velocity, into = speed * unit(-angle), speed * np.sin(angle)
        sim = launched(FLOOR, np.array([-2.0, RADIUS]) - 0.1 * velocity, velocity)
        _, positions, velocities = flight(sim, 1.0)
        assert len(sim.take_impacts()) == (into > IMPACT_SPEED), case
        assert velocities[-1][0] >= speed * np.cos(angle) - FRICTION * (1 + RESTITUTION) * into - 1e-9, case
        assert velocities[-1][1] >= 0.0, case
        assert room(FLOOR, positions).min() >= -overlap(into), case


def test_a_chain_of_circles_throws_back_once():
    """Also into the notch between two of them, which the robot meets at the same instant."""
    for case in product(np.radians([2.0, 10.0, 45.0, 90.0]), (0.0, 0.02, BALL)):
        angle, offset = case
        # from just above the circles down to a centimetre below their tops
        start = np.array([offset, RADIUS - 0.01]) - 0.011 / np.sin(angle) * unit(-angle)
        sim = launched(CHAIN, start, V_MAX * unit(-angle))
        _, positions, velocities = flight(sim, 0.5)
        impacts = sim.take_impacts()
        assert 1 <= len(impacts) <= 3, case
        assert_counted_once(impacts)
        assert room(CHAIN, positions).min() >= -overlap(V_MAX), case
        assert np.linalg.norm(velocities[-1]) > 0.2, case


def test_nothing_tunnels_at_three_times_full_speed():
    """A wall of 1 mm and a pole of 1 mm, at the slowest physics rate."""
    wall = [(1.0, -1.0), (1.001, -1.0), (1.001, 1.0), (1.0, 1.0)]
    world = make_world([wall], circles=[(-1.0, 0.0, 0.001)])
    for case in product(np.linspace(0.0, 3 * V_MAX / 400, 7), (1.0, -1.0)):
        shift, sign = case
        sim = launched(world, (shift, 0.0), (sign * 3 * V_MAX, 0.0), quiet(physics_rate=400.0))
        _, positions, velocities = flight(sim, 0.4)
        assert np.abs(positions[:, 0]).max() <= 1.0 - RADIUS + 3 * V_MAX / 400 + SLOP, case
        assert velocities[-1] == pytest.approx([-RESTITUTION * sign * 3 * V_MAX, 0.0], abs=1e-6), case


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


@settings(max_examples=20)
@given(st.integers(0, 2**31 - 1), st.floats(-np.pi, np.pi), st.floats(0.05, 3 * V_MAX))
def test_free_flight_stays_outside_and_never_gains(seed, direction, speed):
    config = quiet(restitution_spread=0.2, friction_spread=0.1, wall_spread=0.2)
    sim = launched(CLUTTER, (0.8, 0.4), speed * unit(direction), config, seed)
    positions, energies = [], [energy_of(sim)]
    for _ in range(2 * STEPS):
        sim.step()
        positions.append(sim.state.position)
        energies.append(energy_of(sim))
    assert room(CLUTTER, np.array(positions)).min() >= -2 * overlap(speed)
    assert (np.diff(energies) <= 1e-9 * energies[0] + 1e-12).all()
    assert all(impact.velocity_before @ impact.normal < 0.0 for impact in sim.take_impacts())
