"""`collplan/Bounce-v0`: gymnasium's own check, its figures against a trial, strategies as policies, a vector of it."""

import copy
import pickle
from dataclasses import replace
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from shifted_starts import each_shift, shifted

import collplan_gym
from collplan_core.parameters import ParameterError, Settings
from collplan_core.worlds import Mover, WorldError, load_world, save_world
from collplan_core.worlds.movers import place_at
from collplan_gym.measured_robot import MeasuredRobot
from omnipuck_sim.trial import run_trial

BOUNCE = "collplan/Bounce-v0"


def drive(env, policy, seed):
    observation, info = env.reset(seed=seed)
    passed, contacts, ended = 0.0, 0, False
    while not ended:
        observation, reward, arrived, late, info = env.step(policy(observation, info))
        passed, contacts, ended = passed - reward, contacts + info["contacts"], arrived or late
    return passed, contacts, arrived


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("world", ["serpentine", "corridor"])
def test_gymnasium_finds_no_fault(world):
    check_env(gymnasium.make(BOUNCE, world=world).unwrapped, skip_render_check=True)


@each_shift
@pytest.mark.parametrize(("strategy", "touches"), [("bounce", True), ("avoid", False)])
def test_a_strategy_is_a_policy_that_arrives_as_in_a_trial(strategy, touches, shift):
    world = shifted("serpentine:2", shift)
    env, policy = gymnasium.make(BOUNCE, world=world), collplan_gym.PlannerPolicy(strategy)
    passed, contacts, arrived = drive(env, policy, seed=3)
    settings = Settings().with_values({"planner.strategy": strategy})
    assert arrived
    assert passed == pytest.approx(run_trial(world, settings, 3).arrival_time, rel=0.15)
    assert (contacts > 0) == touches


def test_what_is_seen_is_in_the_robots_frame():
    env = gymnasium.make(BOUNCE, world="floor", settings=Settings().with_values({"simulator.noise": 0.0}))
    observation, info = env.reset(seed=1)
    goal = load_world("floor").goal
    np.testing.assert_allclose(info["pose"][:2] + observation["goal"], goal, atol=1e-5)
    began = info["stamp"]
    for _ in range(20):
        observation, *_, info = env.step(np.array([0.0, 5.0]))
    assert observation["velocity"] == pytest.approx([0.0, Settings().robot.max_speed], abs=0.02)
    assert info["stamp"] - began == pytest.approx(1.0)


def test_a_family_gives_another_world_at_each_reset_and_equal_seeds_equal_ones():
    env = gymnasium.make(BOUNCE, world="serpentine")
    scans = [env.reset(seed=seed)[0]["scan"] for seed in (1, None, 1)]
    assert not np.array_equal(scans[0], scans[1])
    np.testing.assert_array_equal(scans[0], scans[2])


def test_a_vector_of_processes():
    envs = gymnasium.make_vec(BOUNCE, num_envs=2, vectorization_mode="async", world="u")
    try:
        observation, info = envs.reset(seed=1)
        assert observation["scan"].shape == (2, 360)
        *_, info = envs.step(envs.action_space.sample())
        assert info["pose"].shape == (2, 3)
    finally:
        envs.close()


WRONG = [
    ({"world": 7}, TypeError, "world: got 7, expected"),
    ({"world": Path("missing.yaml")}, WorldError, "no such file"),
    ({"settings": {"a": 1}}, TypeError, "settings: got .*expected Settings"),
    ({"render_mode": "human"}, ValueError, "render_mode: got 'human', expected None"),
]


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(("given", "kind", "words"), WRONG)
def test_a_wrong_argument_is_named_with_what_was_expected(given, kind, words):
    with pytest.raises(kind, match=words):
        gymnasium.make(BOUNCE, **given)


def test_a_path_is_a_world_numbers_of_numpy_are_numbers_and_a_driven_robot_cannot_be_copied(tmp_path):
    save_world(load_world("u:1"), tmp_path / "u.yaml")
    env = gymnasium.make(BOUNCE, world=tmp_path / "u.yaml", max_episode_steps=5).unwrapped
    copy.deepcopy(env).reset(seed=np.int64(3))
    env.reset(seed=np.uint8(3))
    with pytest.raises(TypeError, match="cannot be copied or pickled"):
        pickle.dumps(env)
    with pytest.raises(ValueError, match="action: got 'ab', expected 2 finite"):
        env.step("ab")


def test_what_cannot_be_simulated_is_refused():
    with pytest.raises(WorldError, match="serpentin"):
        gymnasium.make(BOUNCE, world="serpentin:1")
    for key, value in (("lidar.sensor", "low_cost"), ("simulator.mocap_latency", 0.03)):
        with pytest.raises(ParameterError, match=key):
            gymnasium.make(BOUNCE, world="u:1", settings=Settings().with_values({key: value})).reset()
    env = gymnasium.make(BOUNCE, world="u:1")
    env.reset()
    with pytest.raises(ValueError, match="finite"):
        env.step(np.array([np.nan, 0.0]))


def test_a_mover_is_in_the_scans_of_the_measured_robot():
    mover = Mover(0.15, np.array([[0.4, 1.0], [0.4, 1.8]]), 0.8, to_and_fro=False)
    robot = MeasuredRobot(replace(load_world("floor"), movers=(mover,)), Settings(), 0)
    for _ in range(10):
        measured = robot.rest()
        apart = np.array(place_at(mover, measured.newest.stamp)) - measured.newest.position
        assert measured.scan.ranges.min() == pytest.approx(np.hypot(*apart) - mover.radius, abs=0.002)


def test_a_step_lasts_what_its_reward_counts_or_the_rates_are_refused():
    """40 steps; a mocap that measures less often than the controller commands gives no state for some of them."""
    for physics, mocap, control, runs in (
        (1000.0, 100.0, 20.0, True),
        (1000.0, 100.0, 100.0, True),
        (1000.0, 100.0, 12.5, True),
        (1000.0, 50.0, 25.0, True),
        (1200.0, 60.0, 30.0, True),
        (1000.0, 100.0, 30.0, False),
        (1000.0, 100.0, 15.0, False),
        (1000.0, 100.0, 200.0, False),
        (1000.0, 30.0, 20.0, False),
        (1000.0, 30.0, 30.0, False),
        (1000.0, 10.0, 20.0, False),
        (1000.0, 60.0, 20.0, False),
    ):
        rates = {"simulator.physics_rate": physics, "simulator.mocap_rate": mocap, "controller.rate": control}
        env = gymnasium.make(BOUNCE, world="floor", settings=Settings().with_values(rates))
        if not runs:
            with pytest.raises(ParameterError, match=f"got ({mocap:g}|{control:g}) Hz, expected .* whole number"):
                env.reset(seed=1)
            continue
        began = env.reset(seed=1)[1]["stamp"]
        steps = [env.step(np.array([0.2, 0.0], np.float32)) for _ in range(40)]
        assert steps[-1][-1]["stamp"] - began == pytest.approx(-sum(step[1] for step in steps)), rates
