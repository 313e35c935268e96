"""Grazing, chains, wedges, clutter: nothing hits twice, sticks, tunnels or gains energy; single hits in closed form."""

from itertools import product

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from omnipuck_sim.robot import disc
from omnipuck_sim.robot.disc import IMPACT_SPEED, SLOP
from physics_scenes import (
    FRICTION,
    QUIET,
    RADIUS,
    RESTITUTION,
    V_MAX,
    WALL,
    energy_of,
    flight,
    hit,
    launched,
    make_world,
    quiet,
    rigid_disc,
    unit,
)

STEPS = round(QUIET.simulator.physics_rate)
FLOOR = make_world([[(-5.0, -1.0), (5.0, -1.0), (5.0, 0.0), (-5.0, 0.0)]])
BALL = 0.075


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


def test_nothing_tunnels_at_three_times_full_speed():
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


SPEEDS = (0.3, 0.7, 1.2)


def test_a_flat_wall_gives_the_closed_form():
    angles = np.radians([-80, -60, -45, -20, -3, 0, 10, 30, 50, 70])
    for case in product(angles, (0.1, *SPEEDS, 3.6), (-6.0, 0.0, 6.0)):
        angle, speed, spin = case
        velocity = speed * unit(angle)
        expected, expected_spin = rigid_disc(velocity, spin, np.array([-1.0, 0.0]))
        found, found_spin = hit(velocity, spin=spin)
        np.testing.assert_allclose(found, expected, atol=1e-6, err_msg=str(case))
        assert found_spin == pytest.approx(expected_spin, abs=1e-6), case


def test_flights_between_touches_are_pymunk_s_to_the_last_bit(monkeypatch):
    """Along a wall that the wheels press it against, which it leaves for a few steps again and again."""

    def driven() -> np.ndarray:
        sim = launched(WALL, (0.2, -1.0), (0.5, 0.3))
        sim.drive = True
        positions = []
        for k in range(1600):
            if k % 40 == 0:
                sim.command(np.array([0.3, 0.8]), 0.0)
            sim.step()
            positions.append(sim.state.position)
        return np.array(positions)

    flown = driven()
    monkeypatch.setattr(disc, "flown", lambda *arguments: 0)
    np.testing.assert_array_equal(driven(), flown)


def test_an_inner_corner_is_two_hits_in_order():
    world = make_world(walled=True, bounds=(0.0, 0.0, 1.0, 1.0))
    corner = np.array([1.0 - RADIUS, RADIUS])
    for direction in np.radians([-20.0, -45.0, -70.0]):
        velocity = V_MAX * unit(direction)
        sim = launched(world, corner - 0.1 * velocity + [0.0, 0.01], velocity)
        for _ in range(200):
            sim.step()
        first, second = sim.take_impacts()
        after, spin = rigid_disc(velocity, 0.0, first.normal)
        np.testing.assert_allclose(first.velocity_after, after, atol=1e-6)
        np.testing.assert_allclose(second.velocity_after, rigid_disc(after, spin, second.normal)[0], atol=1e-6)


def test_wheels_keep_their_speed_in_a_hit_and_traction_pulls_the_body_back_into_the_wall():
    slowest = []
    for each in (QUIET, quiet(wheel_mass=0.35)):
        sim = launched(WALL, (0.2, 0.0), (1.0, 0.0), each)
        sim.drive = True
        sim.command(np.array([1.0, 0.0]), 0.0)
        while sim.state.velocity[0] > 0.0:
            sim.step()
        sim.command(np.zeros(2), 0.0)
        for _ in range(60):
            sim.step()
        slowest.append(-sim.state.velocity[0])
    assert slowest[1] < 0.8 * slowest[0]
