"""Trials with sensors as they are: the low-cost LIDAR, noise of the yaw, poses that come late."""

from functools import cache

import numpy as np
import pytest

from collplan_core.evaluation.run_end import REACHED
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import Settings
from collplan_core.sensing.spinning_lidar import LD19
from collplan_core.worlds import load_world
from collplan_core.worlds.raycast import simulate_scan
from omnipuck_sim.trial import run_trial
from omnipuck_sim.trial_record import TrialResult

SETTINGS = Settings()
STEP = 1.0 / SETTINGS.simulator.physics_rate


class Heard:
    """What planner and controller took, each with the time they took it."""

    def __init__(self, monkeypatch) -> None:
        self.poses, self.scans = [], []
        for loop in (PlannerLoop, ControllerLoop):
            for name, kept in (("take_pose", self.poses), ("take_scan", self.scans)):
                self._listen(monkeypatch, loop, name, kept)

    @staticmethod
    def _listen(monkeypatch, loop, name, kept) -> None:
        take = getattr(loop, name)

        def listening(self, taken, local):
            kept.append((loop, taken, local))
            return take(self, taken, local)

        monkeypatch.setattr(loop, name, listening)

    def delays(self, kept, loop) -> np.ndarray:
        """Time from each stamp to its receipt [s]."""
        return np.array([local - taken.stamp for who, taken, local in kept if who is loop])


def run(strategy="stop_guarantee", world="corridor", seed=0, **values) -> TrialResult:
    settings = SETTINGS.with_values({"planner.strategy": strategy, **values})
    return run_trial(load_world(world), settings, seed)


@cache
def low_cost(seed: int = 0) -> TrialResult:
    return run(seed=seed, **{"lidar.sensor": "low_cost"})


def test_the_goal_is_reached_with_a_low_cost_lidar():
    assert low_cost().outcome == REACHED


def test_equal_seeds_give_equal_runs_with_it():
    again = run(**{"lidar.sensor": "low_cost"})
    assert again.trajectory.tobytes() == low_cost().trajectory.tobytes()


def test_scans_come_late_by_sweep_and_latency(monkeypatch):
    heard = Heard(monkeypatch)
    run(**{"lidar.sensor": "low_cost", "trial.timeout": 1.0})
    for loop in (PlannerLoop, ControllerLoop):
        delays = heard.delays(heard.scans, loop)
        assert len(delays) > 8
        np.testing.assert_allclose(delays, LD19.sweep_time + LD19.latency, atol=0.6 * STEP)


def test_beams_are_cast_from_where_the_robot_truly_is(monkeypatch):
    """Mocap noise moves the poses, not the LIDAR: with a large one the scans fit the truth all the same."""
    heard = Heard(monkeypatch)
    world = load_world("corridor")
    quick = {
        "lidar.sensor": "low_cost",
        "trial.timeout": 1.0,
        "simulator.mocap_noise": 0.1,
        "simulator.start_noise": 0.0,
    }
    run(**quick)
    first = heard.scans[0][1]
    # the robot has not moved yet
    truth = heard.poses[0][1]
    at_start = type(truth)(0.0, np.asarray(world.start, dtype=float), np.zeros(2), 0.0)
    ideal = simulate_scan(world, at_start, SETTINGS.with_values({"lidar.n_beams": LD19.n_beams}).lidar)
    errors = (first.ranges - ideal.ranges)[np.isfinite(first.ranges - ideal.ranges)]
    assert abs(np.median(errors)) < 0.003
    assert np.percentile(abs(errors), 80) < 0.03


def test_the_ideal_lidar_is_cast_from_the_measured_pose_at_once(monkeypatch):
    heard = Heard(monkeypatch)
    run(**{"trial.timeout": 1.0})
    poses = {state.stamp: state for loop, state, _ in heard.poses if loop is ControllerLoop}
    scans = [scan for loop, scan, _ in heard.scans if loop is ControllerLoop]
    assert len(scans) > 15
    for scan in scans:
        ideal = simulate_scan(load_world("corridor"), poses[scan.stamp], SETTINGS.lidar)
        assert scan.ranges.tobytes() == ideal.ranges.tobytes()
        assert scan.time_increment == 0.0


@pytest.mark.parametrize("latency", [0.0, 0.023, 0.1])
def test_poses_come_late_by_their_latency(monkeypatch, latency):
    heard = Heard(monkeypatch)
    run(**{"simulator.mocap_latency": latency, "trial.timeout": 1.0})
    for loop in (PlannerLoop, ControllerLoop):
        delays = heard.delays(heard.poses, loop)
        assert len(delays) > 80
        np.testing.assert_allclose(delays, latency, atol=0.6 * STEP)


def test_the_goal_is_reached_with_late_poses_and_a_noisy_yaw():
    assert run(**{"simulator.mocap_latency": 0.03, "simulator.mocap_yaw_noise": 0.01}).outcome == REACHED


def test_nothing_else_follows_from_a_yaw_noise_of_zero():
    """Its stream is its own: the noise of positions, and with it the run, is what it is without it."""
    beginning = {"trial.timeout": 2.0}
    noisy = run(**beginning, **{"simulator.mocap_yaw_noise": 1e-12})
    np.testing.assert_allclose(noisy.trajectory[:100], run(**beginning).trajectory[:100], atol=1e-6)
