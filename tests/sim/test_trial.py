"""The closed loop without ROS, with the paper's strategies; a goal is reached at rest with every strategy."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from collplan_core.command import MANEUVERS
from collplan_core.evaluation.run_end import ACTUATION_BIAS, ACTUATION_NOISE, REACHED, STUCK, TIMEOUT
from collplan_core.goal import AT_REST
from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of
from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL
from collplan_core.worlds import load_world
from omnipuck_sim.trial import run_trial
from omnipuck_sim.trial_record import TrialResult
from physics_scenes import RADIUS, make_world

ARENAS = ("corridor", "l_corridor", "slalom")
STRATEGIES = sorted(PAPER_WEIGHTS)
SETTINGS = Settings()
PASSAGE_ROW = 0.65
"""A height at which the first passage of the corridor lies between its pillars [m]."""
PASSAGE = (1.02, 1.28)
"""Its sides there [m]."""


def settings_of(strategy: str, **values) -> Settings:
    return SETTINGS.with_values({"planner.strategy": strategy, **values})


@cache
def trial(world: str, strategy: str, seed: int = 0) -> TrialResult:
    return run_trial(load_world(world), settings_of(strategy), seed)


def takes_passage(run: TrialResult) -> bool:
    """Whether the run first crosses the row of the first passage through the passage."""
    crossing = np.argmax(run.trajectory[:, 2] > PASSAGE_ROW)
    return bool(PASSAGE[0] < run.trajectory[crossing, 1] < PASSAGE[1])


@pytest.mark.parametrize("seeds", [range(3), pytest.param(range(20), marks=pytest.mark.soak)])
def test_in_the_corridor_low_risk_takes_the_detour_and_high_risk_the_passage(seeds):
    low, high = ([takes_passage(trial("corridor", s, k)) for k in seeds] for s in ("low_risk", "high_risk"))
    assert np.mean(low) <= 0.2, low
    assert np.mean(high) >= 0.8, high


def test_what_a_run_reports_fits_together():
    noise = 5 * (ACTUATION_NOISE + ACTUATION_BIAS)
    fastest = SETTINGS.robot.max_speed + noise
    for world, strategy in zip(ARENAS, STRATEGIES, strict=True):
        result = trial(world, strategy)
        times, positions, velocities = result.trajectory[:, 0], result.trajectory[:, 1:3], result.trajectory[:, 3:]
        assert (result.world, result.strategy, result.seed) == (world, strategy, 0)
        np.testing.assert_allclose(np.diff(times), 1 / SETTINGS.simulator.mocap_rate, atol=1e-9)
        assert result.arrival_time == times[-1]
        goal = load_world(world).goal
        assert np.hypot(*(positions[-1] - goal)) <= SETTINGS.planner.goal_tolerance + 5 * SETTINGS.simulator.mocap_noise
        chords = np.hypot(*np.diff(positions, axis=0).T)
        assert np.hypot(*(positions[-1] - positions[0])) <= result.path_length <= chords.sum() * (1 + 1e-6)
        assert len(result.plans) == len(result.plan_times) == len(result.candidates)
        assert abs(len(result.plans) - result.arrival_time / map_period_of(SETTINGS.planner)) <= 3
        assert (result.candidates <= result.candidates_before_pruning).all()
        assert set(result.maneuvers) <= set(MANEUVERS)
        assert abs(sum(result.maneuvers.values()) - result.arrival_time * SETTINGS.controller.rate) <= 12
        assert len(result.foreseen) == len(result.impacts)
        # actuation noise and bias come on top of what is commanded
        assert np.hypot(*velocities.T).max() <= fastest
        for impact in result.impacts:
            assert np.hypot(*impact.velocity_before) <= fastest
            assert np.hypot(*impact.velocity_after) <= np.hypot(*impact.velocity_before) + 1e-9


def test_how_runs_end_that_do_not_arrive():
    quick = settings_of("harness", **{"trial.timeout": 5.0})
    room = make_world(walled=True, bounds=(-0.4, -0.4, 0.4, 0.4), start=np.zeros(2))
    closed = run_trial(room, quick, 0, goal=np.array([3.0, 0.0]))
    assert (closed.outcome, closed.arrival_time, len(closed.plans)) == (STUCK, 5.0, 0)

    late = run_trial(load_world("corridor"), settings_of("harness", **{"trial.timeout": 1.0}), 0)
    assert (late.outcome, late.arrival_time) == (TIMEOUT, 1.0)
    # the limit counts from the first plan, the trajectory from the first command, one control period later at most
    assert 0.94 <= late.trajectory[-1, 0] <= 1.0


def test_a_start_at_the_goal_is_an_arrival_at_once():
    world = make_world(walled=True, bounds=(-1.0, -1.0, 1.0, 1.0), start=np.zeros(2))
    result = run_trial(world, settings_of("harness"), 0, goal=np.array([0.01, 0.0]))
    assert (result.outcome, result.arrival_time, result.path_length) == (REACHED, 0.0, 0.0)


GOAL = np.array([0.8, 0.0])
NOISE = 0.07
"""A velocity measured as rest may truly be so much faster: three deviations of the noise [m/s]."""


@pytest.mark.parametrize(
    ("strategy", "behind"), [*((name, RADIUS + 0.05) for name in (*PAPER_WEIGHTS, *TIME_TO_GOAL)), ("bounce", 1.0)]
)
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
