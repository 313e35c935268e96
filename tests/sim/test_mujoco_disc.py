"""The disc with a compliant ring, alone: against Coulomb's theory, and its impacts against those of the rigid one."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: it needs Python 3.11")

from omnipuck_sim.robot import mujoco_disc
from omnipuck_sim.robot.impact import IMPACT_SPEED
from omnipuck_sim.robot.physics import Simulator
from physics_scenes import QUIET, RADIUS, energy_of, flight, launched, make_world, quiet, unit

V_MAX = QUIET.robot.max_speed
ROLLS = QUIET.robot.inertia_factor
WALL = make_world([[(0.5, -3.0), (1.0, -3.0), (1.0, 3.0), (0.5, 3.0)]])
SPEEDS = (0.3, 0.7, 1.2)


def soft(**simulation):
    return quiet(engine="mujoco", **simulation)


def hit(angle: float, speed: float, settings, spin: float = 0.0):
    """Restitution and change of the velocity along the wall over the speed, of a hit at an angle from the normal."""
    velocity = speed * unit(angle)
    sim = launched(WALL, (0.41 - 0.02 * np.cos(angle), -0.02 * np.sin(angle)), velocity, settings)
    sim._disc.body.angular_velocity = spin
    before = energy_of(sim)
    flight(sim, 0.1 / (speed * np.cos(angle)) + 2.0 * settings.simulator.contact_time)
    assert energy_of(sim) < before
    after = sim.state.velocity
    return -after[0] / velocity[0], (after[1] - velocity[1]) / speed


def coulomb(angle: float, speed: float, simulation, spin: float = 0.0) -> float:
    """The change along the wall over the speed that Coulomb's friction makes: it slides through, or rolls off."""
    slip = np.sin(angle) + spin * RADIUS / speed
    largest = simulation.friction * (1.0 + simulation.restitution) * np.cos(angle)
    return -np.sign(slip) * min(largest, ROLLS * abs(slip))


@pytest.mark.parametrize("speed", [*SPEEDS, 3 * V_MAX])
@pytest.mark.parametrize("angle", np.radians([-60, -30, 0, 15, 45, 75]))
@pytest.mark.parametrize(
    "ring", [{}, {"contact_time": 0.04}, {"friction": 0.03}, {"friction": 0.5}, {"restitution": 0.4}], ids=str
)
def test_rebounds_follow_coulomb(ring, angle, speed):
    """Within 0.04 where the hit is not oblique; MuJoCo's friction pushes off the wall, or holds, at the others."""
    settings = soft(**ring)
    restitution, change = hit(angle, speed, settings)
    oblique = abs(angle) > np.radians(50.0)
    assert restitution == pytest.approx(settings.simulator.restitution, abs=0.17 if oblique else 0.04)
    assert change == pytest.approx(coulomb(angle, speed, settings.simulator), abs=0.02)


@pytest.mark.parametrize("spin", [-6.0, 6.0])
def test_spin_before_counts(spin):
    restitution, change = hit(0.5, 0.7, soft(), spin)
    assert restitution == pytest.approx(0.7, abs=0.05)
    assert change == pytest.approx(coulomb(0.5, 0.7, soft().simulator, spin), abs=0.03)


@pytest.mark.parametrize("angle", np.radians([0, 30, 45, 60]))
def test_half_the_step_changes_no_rebound(angle, monkeypatch):
    whole = hit(angle, 0.7, soft())
    monkeypatch.setattr(mujoco_disc, "LONGEST_STEP", 0.5 * mujoco_disc.LONGEST_STEP)
    half = hit(angle, 0.7, soft())
    assert half != whole
    np.testing.assert_allclose(half, whole, atol=0.01)


@pytest.mark.parametrize("rate", [400.0, 600.0, 1000.0, 5000.0])
def test_rebounds_do_not_depend_on_the_physics_rate(rate):
    np.testing.assert_allclose(hit(0.5, 0.7, soft(physics_rate=rate)), hit(0.5, 0.7, soft()), atol=0.01)


@pytest.mark.parametrize("contact_time", [0.005, 0.015, 0.04])
def test_a_hit_lasts_the_contact_time(contact_time):
    sim = launched(WALL, (0.38, 0.0), (0.7, 0.0), soft(contact_time=contact_time))
    times, _, velocities = flight(sim, 0.1 + 2.0 * contact_time)
    pushed = times[1:][np.abs(np.diff(velocities[:, 0])) > 1e-6]
    assert pushed[-1] - pushed[0] == pytest.approx(contact_time, abs=0.0021)


def test_restitution_falls_with_speed_where_asked():
    for speed in SPEEDS:
        restitution, _ = hit(0.0, speed, soft(restitution_slope=0.2))
        assert restitution == pytest.approx(0.7 - 0.2 * speed, abs=0.02)


def test_restitution_and_friction_spread_from_hit_to_hit_and_restitution_from_wall_to_wall():
    def spread(seeds, **simulation):
        found = []
        for seed in seeds:
            sim = launched(WALL, (0.4, 0.0), 0.7 * unit(1.0), soft(**simulation), seed)
            flight(sim, 0.2)
            found.append(sim.state.velocity)
        return np.ptp(found, axis=0)

    still, normal, along, walls = (
        spread(range(8), **{key: 0.1} if key else {})
        for key in ("", "restitution_spread", "friction_spread", "wall_spread")
    )
    assert not still.any()
    assert normal[0] > 0.02
    assert walls[0] > 0.02
    assert along[1] > 0.02


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("contact_time", [0.015, 0.04])
def test_energy_falls_at_every_hit_and_nothing_goes_through_a_wall_at_three_times_full_speed(seed, contact_time):
    thin = [(1.0, -1.0), (1.001, -1.0), (1.001, 1.0), (1.0, 1.0)]
    wedge = [(0.0, 0.6), (0.5, 0.62), (0.0, 0.9)]
    world = make_world([thin, wedge], circles=[(-0.5, 0.0, 0.001)], walled=True, bounds=(-1.5, -1.0, 1.5, 1.0))
    sim = launched(world, (0.3, 0.2), 3 * V_MAX * unit(1.0 * seed), soft(contact_time=contact_time))
    free, hits = energy_of(sim), 0
    for _ in range(2000):
        sim.step()
        if not sim._disc._touching:
            assert energy_of(sim) <= free * (1 + 1e-9)
            free = energy_of(sim)
        x, y = sim.state.position
        depth = 3 * V_MAX * contact_time / np.pi
        assert -1.5 + RADIUS - depth <= x <= 1.0 - RADIUS + depth
        assert abs(y) <= 1.0 - RADIUS + depth
        hits += len(sim.take_impacts())
    assert hits >= 2


def impacts_of(world, position, velocity, settings, duration=1.0):
    sim = launched(world, position, velocity, settings)
    flight(sim, duration)
    return sim.take_impacts()


SCENES = {
    "wall": (WALL, (0.2, 0.0), (0.7, 0.3)),
    "corner": (make_world([[(0.5, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 1.0)]]), (0.2, -0.05), (0.8, 0.0)),
    "circle": (make_world(circles=[(0.5, 0.02, 0.05)]), (0.2, 0.0), (0.7, 0.0)),
    "inner corner": (make_world(walled=True, bounds=(0.0, 0.0, 1.0, 1.0)), (0.6, 0.5), V_MAX * unit(-1.1)),
}


@pytest.mark.parametrize("scene", SCENES)
def test_impacts_are_told_as_those_of_the_rigid_disc(scene):
    found, rigid = (impacts_of(*SCENES[scene], settings) for settings in (soft(contact_time=0.005), quiet()))
    assert len(found) == len(rigid) >= 1
    for ours, theirs in zip(found, rigid, strict=True):
        assert ours.time == pytest.approx(theirs.time, abs=0.02)
        np.testing.assert_allclose(ours.point, theirs.point, atol=0.03)
        np.testing.assert_allclose(ours.normal, theirs.normal, atol=0.05)
        np.testing.assert_allclose(ours.velocity_before, theirs.velocity_before, atol=0.05)
        np.testing.assert_allclose(ours.velocity_after, theirs.velocity_after, atol=0.06)


def test_an_impact_is_told_when_it_has_ended():
    sim = launched(WALL, (0.4099, 0.0), (0.7, 0.0), soft())
    for _ in range(10):
        sim.step()
        assert sim.take_impacts() == []
    flight(sim, 0.05)
    (impact,) = sim.take_impacts()
    assert impact.time < 0.002
    assert -impact.velocity_after[0] == pytest.approx(0.7 * impact.velocity_before[0], rel=0.02)


@pytest.mark.parametrize(("speed", "expected"), [(0.9 * IMPACT_SPEED, 0), (1.1 * IMPACT_SPEED, 1)])
def test_a_slow_touch_is_no_impact(speed, expected):
    assert len(impacts_of(WALL, (0.4, 0.0), (speed, 0.5), soft())) == expected


def test_pressing_on_a_wall_is_one_impact_that_ends():
    sim = launched(WALL, (0.3, 0.0), (0.3, 0.0), soft(restitution=0.1))
    sim.drive = True
    for k in range(1000):
        if k % 50 == 0:
            sim.command(np.array([0.5, 0.0]), 0.0)
        sim.step()
    assert len(sim.take_impacts()) == 1
    assert sim.state.position[0] == pytest.approx(0.5 - RADIUS, abs=1e-3)


@pytest.mark.parametrize("friction", [0.12, 0.5])
@pytest.mark.parametrize("angle", np.radians([2.0, 30.0, 60.0]))
def test_pressed_along_a_wall_it_slides_as_the_rigid_disc(angle, friction):
    floor = make_world([[(-5.0, -1.0), (5.0, -1.0), (5.0, 0.0), (-5.0, 0.0)]])
    ends = []
    for name in ("pymunk", "mujoco"):
        sim = Simulator(floor, quiet(engine=name, friction=friction), 0, start=np.array([-2.0, RADIUS + 1e-5]))
        for _ in range(2000):
            sim.command(0.8 * unit(-angle - sim.state.yaw), -2.0 * sim.state.yaw)
            sim.step()
        assert sim.take_impacts() == []
        ends.append(sim.state.position)
    np.testing.assert_allclose(*ends, atol=0.005)
    assert ends[1][0] > -1.9


def test_a_placed_disc_has_forgotten_its_contacts():
    sim = launched(WALL, (0.4, 0.0), (0.7, 0.0), soft())
    flight(sim, 0.02)
    sim.place(np.array([-1.0, 0.0]), np.array([0.3, 0.0]), 0.5)
    _, _, velocities = flight(sim, 0.1)
    assert sim.take_impacts() == []
    assert (velocities == [0.3, 0.0]).all()
    assert sim.state.yaw == 0.5
