"""The best trajectory: between the lower bound and what walls and limits allow. Needs CasADi."""

from itertools import pairwise

import numpy as np
import pytest
import shapely

from collplan_core.parameters import Settings
from collplan_core.worlds import load_world
from collplan_core.worlds.route import free_space
from collplan_study.optimum.best_trajectory import GUESSED_OFFSETS, Trajectory, best_trajectories
from collplan_study.optimum.disc import disc_of
from collplan_study.optimum.free_chain import FreeChain, Region, free_chain
from collplan_study.optimum.lower_bound import lower_bound, rest_to_free
from collplan_study.question.held_out import OPTIMUM_FAMILIES

pytest.importorskip("casadi", reason="NOT TESTED: CasADi is missing, .venv-optimum of make optimum has it")

DISC = disc_of(Settings())
PENETRATION = 1e-3
"""Walls are kept half-way between knots, not everywhere [m]."""


def path_of(trajectory: Trajectory) -> np.ndarray:
    """Positions (m, 2), ten between any two knots."""
    steps = np.diff(trajectory.times)[:, None, None] * np.linspace(0.0, 1.0, 11)[:, None]
    p, v, a = trajectory.positions[:-1, None], trajectory.velocities[:-1, None], trajectory.accelerations[:, None]
    return (p + v * steps + a * steps**2 / 2).reshape(-1, 2)


@pytest.mark.parametrize("family", OPTIMUM_FAMILIES)
def test_it_keeps_walls_and_limits_and_is_no_faster_than_the_bound(family):
    world = load_world(f"{family}:0")
    chain = free_chain(world, DISC.radius)
    found = best_trajectories(chain, DISC)
    assert len(found) == len(GUESSED_OFFSETS)
    assert found[-1].duration / found[0].duration < 1.01
    free = free_space(world, DISC.radius).buffer(PENETRATION)
    for trajectory in found:
        assert trajectory.duration >= lower_bound(chain, DISC) - 1e-6
        assert np.hypot(*trajectory.accelerations.T).max() <= DISC.max_acceleration + 1e-6
        assert np.hypot(*trajectory.velocities.T).max() <= DISC.max_speed + 1e-6
        assert shapely.covers(free, shapely.points(path_of(trajectory))).all()
        assert trajectory.positions[0] == pytest.approx(world.start)
        assert trajectory.velocities[0] == pytest.approx([0.0, 0.0])
        assert np.hypot(*(trajectory.positions[-1] - world.goal)) <= DISC.goal_tolerance + 1e-6
        steps = np.diff(trajectory.times)[:, None]
        assert trajectory.velocities[1:] == pytest.approx(
            trajectory.velocities[:-1] + trajectory.accelerations * steps, abs=1e-6
        )
        ends = path_of(trajectory)[10::11]
        assert ends == pytest.approx(trajectory.positions[1:], abs=1e-6)


def test_in_the_open_it_is_the_closed_form():
    chain = FreeChain((Region(np.zeros(2), np.array([3.0, 1.0])),), np.array([0.5, 0.5]), np.array([2.5, 0.5]))
    expected = rest_to_free(2.0 - DISC.goal_tolerance, DISC.max_speed, DISC.max_acceleration)
    for trajectory in best_trajectories(chain, DISC):
        # the switch from acceleration to full speed falls between two knots
        assert expected - 1e-6 <= trajectory.duration <= 1.002 * expected
        assert all(b[0] > a[0] for a, b in pairwise(trajectory.positions))
