"""The closed loop without ROS."""

import hashlib
import subprocess
import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from collplan_core.command import MANEUVERS
from collplan_core.evaluation.run_end import REACHED, STUCK, TIMEOUT
from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of
from collplan_core.strategies import PAPER_WEIGHTS
from collplan_core.worlds import WorldError, load_world
from omnipuck_sim.trial import run_trial
from omnipuck_sim.trial_record import TrialResult
from physics_scenes import make_world

ARENAS = ("corridor", "l_corridor", "slalom")
SETTINGS = Settings()


def settings_of(strategy: str, **values) -> Settings:
    return SETTINGS.with_values({"planner.strategy": strategy, **values})


@cache
def trial(world: str, strategy: str, seed: int = 0) -> TrialResult:
    return run_trial(load_world(world), settings_of(strategy), seed)


def digest(result: TrialResult) -> str:
    """Hash of all that a trial measures, wall times aside."""
    plans = b"".join(plan.tobytes() for plan in result.plans)
    return hashlib.sha256(
        result.trajectory.tobytes() + plans + repr(sorted(result.maneuvers.items())).encode()
    ).hexdigest()


@pytest.mark.parametrize("strategy", sorted(PAPER_WEIGHTS))
@pytest.mark.parametrize("world", ARENAS)
def test_every_strategy_reaches_the_goal_of_every_arena(world, strategy):
    assert trial(world, strategy).outcome == REACHED


@pytest.mark.soak
@pytest.mark.timeout(900)
def test_the_arenas_are_reached_over_twenty_seeds():
    runs = [(w, s, seed) for w in ARENAS for s in sorted(PAPER_WEIGHTS) for seed in range(20)]
    failed = [run for run in runs if trial(*run).outcome != REACHED]
    assert len(failed) <= 0.02 * len(runs), failed


@pytest.mark.soak
@pytest.mark.timeout(900)
@pytest.mark.parametrize("strategy", sorted(PAPER_WEIGHTS))
def test_random_worlds_are_reached(strategy):
    failed = [seed for seed in range(100) if trial(f"random:{seed}", strategy, seed).outcome != REACHED]
    assert len(failed) <= 2, failed


@pytest.mark.parametrize("strategy", sorted(PAPER_WEIGHTS))
def test_some_random_worlds_are_reached(strategy):
    """A fixed sample of the long count."""
    failed = [seed for seed in range(0, 100, 10) if trial(f"random:{seed}", strategy, seed).outcome != REACHED]
    assert not failed


AGAIN = """
import sys
sys.path.insert(0, sys.argv[1])
from test_trial import digest, trial
print(digest(trial("slalom", "harness", 3)))
"""


def test_a_seed_gives_the_same_run_bit_by_bit_in_another_process():
    here = digest(trial("slalom", "harness", 3))
    folder = __file__.rpartition("/")[0]
    run = subprocess.run([sys.executable, "-c", AGAIN, folder], capture_output=True, text=True, timeout=100, check=True)
    assert run.stdout.strip() == here


def test_a_run_does_not_depend_on_the_runs_before_it():
    first = digest(trial("corridor", "harness", 5))
    run_trial(load_world("slalom"), settings_of("low_risk"), 1)
    assert digest(run_trial(load_world("corridor"), settings_of("harness"), 5)) == first


def test_another_seed_gives_another_run():
    assert digest(trial("corridor", "harness", 0)) != digest(trial("corridor", "harness", 1))


@pytest.mark.parametrize("world", ARENAS)
@pytest.mark.parametrize("strategy", sorted(PAPER_WEIGHTS))
def test_what_a_run_reports_fits_together(world, strategy):
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
    assert abs(len(result.plans) - result.arrival_time / map_period_of(SETTINGS)) <= 3
    assert (result.candidates <= result.candidates_before_pruning).all()
    assert set(result.maneuvers) <= set(MANEUVERS)
    assert abs(sum(result.maneuvers.values()) - result.arrival_time * SETTINGS.controller.rate) <= 12
    assert len(result.foreseen) == len(result.impacts)
    # actuation noise and bias come on top of what is commanded
    noise = 5 * (SETTINGS.simulator.actuation_noise + SETTINGS.simulator.actuation_bias)
    assert np.hypot(*velocities.T).max() <= SETTINGS.robot.max_speed + noise
    for impact in result.impacts:
        assert np.hypot(*impact.velocity_before) <= SETTINGS.robot.max_speed + noise
        assert np.hypot(*impact.velocity_after) <= np.hypot(*impact.velocity_before) + 1e-9


ROOM = (-0.4, -0.4, 0.4, 0.4)


def test_a_goal_that_cannot_be_reached_ends_as_stuck():
    room = make_world(walled=True, bounds=ROOM, start=np.zeros(2))
    quick = settings_of("harness", **{"trial.timeout": 8.0})
    result = run_trial(room, quick, 0, goal=np.array([3.0, 0.0]))
    assert result.outcome == STUCK
    assert result.arrival_time == 8.0
    assert len(result.plans) == 0


def test_a_goal_inside_a_pillar_ends_without_an_exception():
    pillar = [[0.8, -0.3], [1.4, -0.3], [1.4, 0.3], [0.8, 0.3]]
    world = make_world([pillar], walled=True, bounds=(-1.0, -1.0, 2.0, 1.0), start=np.zeros(2))
    result = run_trial(world, settings_of("harness", **{"trial.timeout": 8.0}), 0, goal=np.array([1.1, 0.0]))
    assert result.outcome in (STUCK, TIMEOUT)
    assert result.arrival_time == 8.0


def test_a_start_at_the_goal_is_an_arrival_at_once():
    world = make_world(walled=True, bounds=(-1.0, -1.0, 1.0, 1.0), start=np.zeros(2))
    result = run_trial(world, settings_of("harness"), 0, goal=np.array([0.01, 0.0]))
    assert (result.outcome, result.arrival_time, result.path_length) == (REACHED, 0.0, 0.0)


def test_a_time_limit_ends_a_run():
    result = run_trial(load_world("corridor"), settings_of("harness", **{"trial.timeout": 1.0}), 0)
    assert result.outcome == TIMEOUT
    assert result.arrival_time == 1.0
    # the limit counts from the first plan, the trajectory from the first command, one control period later at most
    assert 0.94 <= result.trajectory[-1, 0] <= 1.0


def test_without_start_or_goal_there_is_no_run():
    with pytest.raises(WorldError, match="goal: missing"):
        run_trial(make_world(start=np.zeros(2)), SETTINGS, 0)
    with pytest.raises(WorldError, match="start"):
        run_trial(make_world(), SETTINGS, 0, goal=np.ones(2))


def test_without_noise_the_open_arena_is_crossed_in_a_straight_line():
    world = replace(make_world(start=np.zeros(2)), goal=np.array([2.0, 0.0]))
    result = run_trial(world, settings_of("harness", **{"simulator.noise": 0.0}), 0)
    assert result.outcome == REACHED
    assert len(result.impacts) == 0
    assert result.path_length == pytest.approx(1.9, abs=0.06)
    assert np.abs(result.trajectory[:, 2]).max() < 0.15
