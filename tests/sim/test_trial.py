"""The closed loop without ROS, with the paper's strategies."""

from functools import cache

import numpy as np
import pytest

from collplan_core.command import MANEUVERS
from collplan_core.evaluation.run_end import ACTUATION_BIAS, ACTUATION_NOISE, REACHED, STUCK, TIMEOUT
from collplan_core.parameters import ParameterError, Settings
from collplan_core.planners import map_period_of
from collplan_core.strategies import PAPER_WEIGHTS
from collplan_core.worlds import WorldError, load_world
from omnipuck_sim.trial import run_trial
from omnipuck_sim.trial_record import TrialResult
from physics_scenes import make_world

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


def not_reached(runs) -> list:
    return [run for run in runs if trial(*run).outcome != REACHED]


def test_every_strategy_reaches_the_goal_of_every_arena_and_of_some_random_worlds():
    arenas = [(world, strategy) for world in ARENAS for strategy in STRATEGIES]
    assert not not_reached([*arenas, *((f"random:{n}", s, n) for n in (0, 10, 20) for s in STRATEGIES)])


@pytest.mark.soak
def test_the_arenas_and_random_worlds_are_reached_over_many_seeds():
    runs = [(w, s, seed) for w in ARENAS for s in STRATEGIES for seed in range(20)]
    assert len(not_reached(runs)) <= 0.02 * len(runs), not_reached(runs)
    for strategy in STRATEGIES:
        failed = not_reached([(f"random:{seed}", strategy, seed) for seed in range(100)])
        assert len(failed) <= 2, failed


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

    pillar = [[0.8, -0.3], [1.4, -0.3], [1.4, 0.3], [0.8, 0.3]]
    world = make_world([pillar], walled=True, bounds=(-1.0, -1.0, 2.0, 1.0), start=np.zeros(2))
    inside = run_trial(world, quick, 0, goal=np.array([1.1, 0.0]))
    assert inside.outcome in (STUCK, TIMEOUT)
    assert inside.arrival_time == 5.0

    late = run_trial(load_world("corridor"), settings_of("harness", **{"trial.timeout": 1.0}), 0)
    assert (late.outcome, late.arrival_time) == (TIMEOUT, 1.0)
    # the limit counts from the first plan, the trajectory from the first command, one control period later at most
    assert 0.94 <= late.trajectory[-1, 0] <= 1.0


def test_a_start_at_the_goal_is_an_arrival_at_once():
    world = make_world(walled=True, bounds=(-1.0, -1.0, 1.0, 1.0), start=np.zeros(2))
    result = run_trial(world, settings_of("harness"), 0, goal=np.array([0.01, 0.0]))
    assert (result.outcome, result.arrival_time, result.path_length) == (REACHED, 0.0, 0.0)


def test_without_start_or_goal_there_is_no_run():
    with pytest.raises(WorldError, match="goal: missing"):
        run_trial(make_world(start=np.zeros(2)), SETTINGS, 0)
    with pytest.raises(WorldError, match="start"):
        run_trial(make_world(), SETTINGS, 0, goal=np.ones(2))


def test_a_planner_that_can_hold_no_map_is_given_none():
    with pytest.raises(ParameterError, match=r"known_map.*harness.*bounce"):
        run_trial(load_world("corridor"), settings_of("harness").with_values({"trial.known_map": True}), 0)
