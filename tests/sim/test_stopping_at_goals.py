"""planner.stop_at_goal: a goal is reached at rest, with every strategy, with a wall close behind it or not."""

from dataclasses import replace

import numpy as np
import pytest

from collplan_core.evaluation.run_end import REACHED
from collplan_core.goal import AT_REST
from collplan_core.parameters import Settings
from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL
from omnipuck_sim.trial import run_trial
from physics_scenes import RADIUS, make_world

GOAL = np.array([0.8, 0.0])
NOISE = 0.07
"""A velocity measured as rest may truly be so much faster: three deviations of the noise [m/s]."""


@pytest.mark.parametrize("behind", [RADIUS + 0.05, 1.0])
@pytest.mark.parametrize("strategy", [*PAPER_WEIGHTS, *TIME_TO_GOAL])
def test_every_strategy_comes_to_rest_at_the_goal(strategy, behind):
    hall = make_world([], walled=True, bounds=(-1.1, -0.4, GOAL[0] + behind, 0.4))
    world = replace(hall, start=np.array([-0.9, 0.0]), goal=GOAL)
    settings = Settings().with_values({"planner.strategy": strategy, "planner.stop_at_goal": True})
    result = run_trial(world, settings, 0)
    assert result.outcome == REACHED
    distances = np.hypot(*(result.trajectory[:, 1:3] - GOAL).T)
    speeds = np.hypot(*result.trajectory[:, 3:].T)
    within = distances <= settings.planner.goal_tolerance
    assert distances[-1] <= settings.planner.goal_tolerance + 0.01
    assert speeds[-1] <= AT_REST + NOISE
    assert speeds[within.argmax()] > AT_REST  # it went on after it had come near
    assert result.arrival_time < 6.0
