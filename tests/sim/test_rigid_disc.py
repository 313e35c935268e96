"""Hits of the simulated robot against the rigid disc's closed form: over angle, speed and spin before."""

from dataclasses import replace

import numpy as np
import pytest

from collplan_core.parameters import Settings, Simulation
from physics_scenes import QUIET, RADIUS, energy_of, launched, make_world, unit

E, MU = QUIET.simulator.restitution, QUIET.simulator.friction
V_MAX = QUIET.robot.max_speed
WALL = [(0.5, -3.0), (1.0, -3.0), (1.0, 3.0), (0.5, 3.0)]
SPEEDS = (0.3, 0.7, 1.2)


def rigid_disc(velocity, spin, normal, factor=QUIET.robot.inertia_factor):
    """Velocity and spin after a hit: Coulomb friction at the contact, which a disc may roll off or slide along."""
    tangent = np.array([-normal[1], normal[0]])
    into = -(velocity @ normal)
    slip = velocity @ tangent - spin * RADIUS
    change = -np.sign(slip) * min(MU * (1 + E) * into, abs(slip) * factor)
    inertia = factor / (1.0 - factor)  # I / (m r^2)
    return velocity + (1 + E) * into * normal + change * tangent, spin - change / (inertia * RADIUS)


@pytest.mark.parametrize("spin", [-6.0, 0.0, 6.0])
@pytest.mark.parametrize("speed", [0.1, *SPEEDS, 3.6])
@pytest.mark.parametrize("angle", np.radians([-80, -60, -45, -20, -3, 0, 10, 30, 50, 70]))
def test_a_flat_wall_gives_the_closed_form(angle, speed, spin):
    velocity = speed * unit(angle)
    sim = launched(make_world([WALL]), (0.41 - 0.02 * np.cos(angle), -0.02 * np.sin(angle)), velocity)
    sim._disc.body.angular_velocity = spin
    while sim.state.velocity @ unit(0.0) > 0.0:
        sim.step()
    expected, expected_spin = rigid_disc(velocity, spin, np.array([-1.0, 0.0]))
    np.testing.assert_allclose(sim.state.velocity, expected, atol=1e-6)
    assert sim.spin == pytest.approx(expected_spin, abs=1e-6)


def errors(world_of, touch_of, normals) -> np.ndarray:
    """Angles between velocities after a hit as simulated and by the closed form [deg]."""
    found = []
    for normal in normals:
        for incidence in np.radians([-60, -40, -20, 0, 20, 40, 60]):
            for speed in SPEEDS:
                for phase in (0.0, 0.37, 0.71):
                    c, s = np.cos(incidence), np.sin(incidence)
                    velocity = -speed * np.array([c * normal[0] - s * normal[1], s * normal[0] + c * normal[1]])
                    start = touch_of(normal) - velocity * (0.03 + phase / QUIET.simulator.physics_rate)
                    sim = launched(world_of, start, velocity)
                    for _ in range(50):
                        sim.step()
                    expected, _ = rigid_disc(velocity, 0.0, normal)
                    got = sim.state.velocity
                    cross = got[0] * expected[1] - got[1] * expected[0]
                    found.append(abs(np.degrees(np.arctan2(cross, got @ expected))))
    return np.array(found)


SQUARE = make_world([[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]])
POLE = make_world(circles=[(0.0, 0.0, 0.05)])
CASES = {
    "corner": (SQUARE, lambda n: RADIUS * n, [unit(a) for a in np.radians(np.linspace(185, 265, 9))]),
    "circle of 5 cm": (POLE, lambda n: (RADIUS + 0.05) * n, [unit(a) for a in np.radians(np.linspace(100, 260, 9))]),
}


@pytest.mark.parametrize("case", CASES)
def test_corners_and_small_circles_are_within_a_degree_in_the_median_and_two_at_most(case):
    found = errors(*CASES[case])
    assert np.median(found) < 1.0
    assert found.max() < 2.0


@pytest.mark.parametrize("direction", np.radians([-20.0, -45.0, -70.0]))
def test_an_inner_corner_is_two_hits_in_order(direction):
    """Far enough from the corner's bisector for the hits to be three steps and more apart."""
    velocity = V_MAX * unit(direction)
    world = make_world(walled=True, bounds=(0.0, 0.0, 1.0, 1.0))
    corner = np.array([1.0 - RADIUS, RADIUS])
    sim = launched(world, corner - 0.1 * velocity + [0.0, 0.01], velocity)
    for _ in range(200):
        sim.step()
    first, second = sim.take_impacts()
    after, spin = rigid_disc(velocity, 0.0, first.normal)
    np.testing.assert_allclose(first.velocity_after, after, atol=1e-6)
    np.testing.assert_allclose(second.velocity_after, rigid_disc(after, spin, second.normal)[0], atol=1e-6)


@pytest.mark.parametrize("seed", range(12))
def test_energy_falls_and_nothing_goes_through_a_wall_at_three_times_full_speed(seed):
    thin = [(1.0, -1.0), (1.001, -1.0), (1.001, 1.0), (1.0, 1.0)]
    wedge = [(0.0, 0.6), (0.5, 0.62), (0.0, 0.9)]
    world = make_world([thin, wedge], circles=[(-0.5, 0.0, 0.001)], walled=True, bounds=(-1.5, -1.0, 1.5, 1.0))
    sim = launched(world, (0.3, 0.2), 3 * V_MAX * unit(0.5 * seed))
    before = energy_of(sim)
    for _ in range(2000):
        sim.step()
        assert energy_of(sim) <= before * (1 + 1e-9) + 1e-12
        before = energy_of(sim)
        x, y = sim.state.position
        depth = 3 * V_MAX / QUIET.simulator.physics_rate + 1e-4
        assert -1.5 + RADIUS - depth <= x <= 1.0 - RADIUS + depth
        assert abs(y) <= 1.0 - RADIUS + depth


def test_wheels_keep_their_speed_in_a_hit_and_traction_pulls_the_body_back_into_the_wall():
    heavy = Settings(simulator=Simulation(noise=0.0, wheel_mass=0.35))
    slowest = []
    for settings in (QUIET, replace(QUIET, simulator=heavy.simulator)):
        sim = launched(make_world([WALL]), (0.2, 0.0), (1.0, 0.0), settings)
        sim.drive = True
        sim.command(np.array([1.0, 0.0]), 0.0)
        while sim.state.velocity[0] > 0.0:
            sim.step()
        sim.command(np.zeros(2), 0.0)
        for _ in range(60):
            sim.step()
        slowest.append(-sim.state.velocity[0])
    assert slowest[1] < 0.8 * slowest[0]


def test_restitution_falls_with_speed_where_asked():
    settings = Settings(simulator=Simulation(noise=0.0, restitution_slope=0.2))
    for speed in SPEEDS:
        sim = launched(make_world([WALL]), (0.38, 0.0), (speed, 0.0), settings)
        while sim.state.velocity[0] > 0.0:
            sim.step()
        assert -sim.state.velocity[0] / speed == pytest.approx(E - 0.2 * speed, abs=1e-6)


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
