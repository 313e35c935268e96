"""A planner is a folder and a line in the table of planners: trials ask nothing else."""

import numpy as np
import pytest
from straight_planner import STRAIGHT

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.planners import PLANNERS, map_period_of
from omnipuck_sim.trial import run_trial
from physics_scenes import make_world

SETTINGS = Settings().with_values({"planner.strategy": "custom"})
GOAL = np.array([1.0, 0.2])


@pytest.fixture(autouse=True)
def straight(monkeypatch):
    monkeypatch.setitem(PLANNERS, "custom", STRAIGHT)


def test_a_trial_follows_it_to_the_goal():
    result = run_trial(make_world(start=(0.0, 0.0)), SETTINGS, 1, GOAL)
    assert result.outcome == REACHED
    assert set(result.maneuvers) <= {"free_space", "stopped"}
    assert abs(len(result.plans) - result.arrival_time / STRAIGHT.map_period) <= 3
    length = np.hypot(*GOAL) - SETTINGS.planner.goal_tolerance
    assert result.path_length == pytest.approx(length, abs=0.1)
    assert result.arrival_time >= length / (0.5 * SETTINGS.robot.max_speed)


def test_its_period_is_its_own_unless_the_parameter_says_otherwise():
    assert map_period_of(SETTINGS) == STRAIGHT.map_period
    assert map_period_of(SETTINGS.with_values({"planner.map_period": 0.3})) == 0.3
