"""A planner is a folder and is registered by a name: trials ask nothing else."""

import numpy as np
import pytest
from straight_planner import STRAIGHT

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.planners import PLANNERS, map_period_of, register
from collplan_core.strategies import NAMES
from omnipuck_sim.trial import run_trial
from physics_scenes import make_world

GOAL = np.array([1.0, 0.2])


@pytest.fixture
def chosen():
    register("straight", STRAIGHT)
    yield Settings().with_values({"planner.strategy": "straight"})
    del PLANNERS["straight"]
    NAMES.remove("straight")


def test_a_trial_follows_it_to_the_goal_in_its_own_period(chosen):
    assert map_period_of(chosen) == STRAIGHT.map_period
    assert map_period_of(chosen.with_values({"planner.map_period": 0.3})) == 0.3
    result = run_trial(make_world(start=(0.0, 0.0)), chosen, 1, GOAL)
    assert result.outcome == REACHED
    assert set(result.maneuvers) <= {"free_space", "stopped"}
    assert abs(len(result.plans) - result.arrival_time / STRAIGHT.map_period) <= 3
    length = np.hypot(*GOAL) - chosen.planner.goal_tolerance
    assert result.path_length == pytest.approx(length, abs=0.1)
    assert result.arrival_time >= length / (0.5 * chosen.robot.max_speed)
