"""Hits of the simulated robot against the rigid disc's closed form: over angle, speed and spin before."""

from itertools import product

import numpy as np
import pytest

from omnipuck_sim.robot import disc
from physics_scenes import QUIET, RADIUS, V_MAX, WALL, hit, launched, make_world, quiet, rigid_disc, unit

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
    """Far enough from the corner's bisector for the hits to be three steps and more apart."""
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
    for settings in (QUIET, quiet(wheel_mass=0.35)):
        sim = launched(WALL, (0.2, 0.0), (1.0, 0.0), settings)
        sim.drive = True
        sim.command(np.array([1.0, 0.0]), 0.0)
        while sim.state.velocity[0] > 0.0:
            sim.step()
        sim.command(np.zeros(2), 0.0)
        for _ in range(60):
            sim.step()
        slowest.append(-sim.state.velocity[0])
    assert slowest[1] < 0.8 * slowest[0]


def test_abutting_rectangles_have_no_seam():
    """A disc pressed along two of them is not thrown off where they meet."""
    left, right = (
        [(-2.0, -1.0), (0.0, -1.0), (0.0, 0.0), (-2.0, 0.0)],
        [(0.0, -1.0), (2.0, -1.0), (2.0, 0.0), (0.0, 0.0)],
    )
    sim = launched(make_world([left, right]), (-0.5, RADIUS + 0.001), (0.8, -0.05))
    highest = 0.0
    for _ in range(1200):
        sim.step()
        highest = max(highest, abs(sim.state.velocity[1]))
    assert sim.state.position[0] > 0.2
    assert highest <= 0.05 + 1e-9
