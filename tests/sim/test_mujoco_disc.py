"""The disc with a compliant ring: against Coulomb's theory, and its impacts against those of the rigid one."""

from itertools import product

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: it needs Python 3.11")

from omnipuck_sim.robot.disc import IMPACT_SPEED
from physics_scenes import (
    RADIUS,
    V_MAX,
    WALL,
    energy,
    energy_of,
    flight,
    hit,
    launched,
    make_world,
    quiet,
    rigid_disc,
    unit,
)

RINGS = ({}, {"contact_time": 0.04}, {"friction": 0.03}, {"friction": 0.5}, {"restitution": 0.4})


def soft(**simulation):
    return quiet(engine="mujoco", **simulation)


def test_rebounds_follow_coulomb():
    """Within 0.04 where the hit is not oblique; MuJoCo's friction pushes off the wall, or holds, at the others."""
    spinning = [(0.5, 0.7, spin, {}) for spin in (-6.0, 6.0)]
    angles = np.radians([-60, -30, 0, 45, 75])
    for case in [*((a, v, 0.0, ring) for a, v, ring in product(angles, (0.3, 1.2, 3 * V_MAX), RINGS)), *spinning]:
        angle, speed, spin, ring = case
        velocity, config = speed * unit(angle), soft(**ring)
        after, spin_after = hit(velocity, config, spin)
        expected, _ = rigid_disc(velocity, spin, np.array([-1.0, 0.0]), config.simulator)
        oblique = abs(angle) > np.radians(50.0)
        restitution = -after[0] / velocity[0]
        assert restitution == pytest.approx(config.simulator.restitution, abs=0.17 if oblique else 0.05), case
        assert after[1] == pytest.approx(expected[1], abs=0.03 * speed), case
        assert energy(after, spin_after) < energy(velocity, spin), case


def test_energy_falls_at_every_hit_and_nothing_goes_through_a_wall_at_three_times_full_speed():
    thin = [(1.0, -1.0), (1.001, -1.0), (1.001, 1.0), (1.0, 1.0)]
    wedge = [(0.0, 0.6), (0.5, 0.62), (0.0, 0.9)]
    world = make_world([thin, wedge], circles=[(-0.5, 0.0, 0.001)], walled=True, bounds=(-1.5, -1.0, 1.5, 1.0))
    for case in product(range(4), (0.015, 0.04)):
        seed, contact_time = case
        sim = launched(world, (0.3, 0.2), 3 * V_MAX * unit(1.0 * seed), soft(contact_time=contact_time))
        free, hits, before = energy_of(sim), 0, sim.state.velocity
        depth = 3 * V_MAX * contact_time / np.pi
        for _ in range(1200):
            sim.step()
            if (sim.state.velocity == before).all():
                # nothing touches it
                assert energy_of(sim) <= free * (1 + 1e-9), case
                free = energy_of(sim)
            before = sim.state.velocity
            x, y = sim.state.position
            assert -1.5 + RADIUS - depth <= x <= 1.0 - RADIUS + depth, case
            assert abs(y) <= 1.0 - RADIUS + depth, case
            hits += len(sim.take_impacts())
        assert hits >= 2, case


def impacts_of(world, position, velocity, config):
    sim = launched(world, position, velocity, config)
    flight(sim, 1.0)
    return sim.take_impacts()


SCENES = {
    "wall": (WALL, (0.2, 0.0), (0.7, 0.3)),
    "corner": (make_world([[(0.5, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 1.0)]]), (0.2, -0.05), (0.8, 0.0)),
    "circle": (make_world(circles=[(0.5, 0.02, 0.05)]), (0.2, 0.0), (0.7, 0.0)),
    "inner corner": (make_world(walled=True, bounds=(0.0, 0.0, 1.0, 1.0)), (0.6, 0.5), V_MAX * unit(-1.1)),
}


def test_impacts_are_those_of_the_rigid_disc():
    for name, scene in SCENES.items():
        found, rigid = (impacts_of(*scene, config) for config in (soft(contact_time=0.005), quiet()))
        assert len(found) == len(rigid) >= 1, name
        for ours, theirs in zip(found, rigid, strict=True):
            assert ours.time == pytest.approx(theirs.time, abs=0.02)
            np.testing.assert_allclose(ours.point, theirs.point, atol=0.03, err_msg=name)
            np.testing.assert_allclose(ours.normal, theirs.normal, atol=0.05, err_msg=name)
            np.testing.assert_allclose(ours.velocity_before, theirs.velocity_before, atol=0.05, err_msg=name)
            np.testing.assert_allclose(ours.velocity_after, theirs.velocity_after, atol=0.06, err_msg=name)


def test_an_impact_is_known_when_it_has_ended_and_a_slow_touch_is_none():
    sim = launched(WALL, (0.4099, 0.0), (0.7, 0.0), soft())
    for _ in range(10):
        sim.step()
        assert sim.take_impacts() == []
    flight(sim, 0.05)
    (impact,) = sim.take_impacts()
    assert impact.time < 0.002
    assert -impact.velocity_after[0] == pytest.approx(0.7 * impact.velocity_before[0], rel=0.02)
    assert [len(impacts_of(WALL, (0.4, 0.0), (f * IMPACT_SPEED, 0.5), soft())) for f in (0.9, 1.1)] == [0, 1]
