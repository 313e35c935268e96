"""Trials with sensors as they are: the low-cost LIDAR, noise of the yaw, poses that come late."""

import numpy as np
import pytest

from collplan_core.evaluation.run_end import REACHED
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import Settings
from collplan_core.worlds import load_world
from collplan_core.worlds.raycast import simulate_scan
from collplan_core.worlds.spinning_lidar import LD19
from omnipuck_sim.trial import run_trial
from omnipuck_sim.trial_record import TrialResult

SETTINGS = Settings()
STEP = 1.0 / SETTINGS.simulator.physics_rate
LOOPS = (PlannerLoop, ControllerLoop)


class Heard:
    """What planner and controller took, each with the time they took it."""

    def __init__(self, monkeypatch) -> None:
        self.poses, self.scans = [], []
        for loop in LOOPS:
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
        return np.array([local - taken.stamp for who, taken, local in kept if who is loop])


@pytest.fixture
def heard(monkeypatch):
    return Heard(monkeypatch)


def run(**values) -> TrialResult:
    settings = SETTINGS.with_values({"planner.strategy": "stop_guarantee", **values})
    return run_trial(load_world("corridor"), settings, 0)


def test_with_a_low_cost_lidar_scans_come_late_by_sweep_and_latency_and_the_goal_is_reached(heard):
    result = run(**{"lidar.sensor": "low_cost"})
    assert result.outcome == REACHED
    for loop in LOOPS:
        delays = heard.delays(heard.scans, loop)
        assert len(delays) > 8
        np.testing.assert_allclose(delays, LD19.sweep_time + LD19.latency, atol=0.6 * STEP)
    again = run(**{"lidar.sensor": "low_cost", "trial.timeout": 1.0}).trajectory
    assert again.tobytes() == result.trajectory[: len(again)].tobytes()


def test_beams_are_cast_from_where_the_robot_truly_is(heard):
    """Mocap noise moves the poses, not the LIDAR: with a large one the scans fit the truth all the same."""
    world = load_world("corridor")
    run(**{"lidar.sensor": "low_cost", "trial.timeout": 1.0, "simulator.noise": 0.1, "simulator.mocap_noise": 0.1})
    # the robot has not moved yet
    first, pose = heard.scans[0][1], heard.poses[0][1]
    at_start = type(pose)(0.0, np.asarray(world.start, dtype=float), np.zeros(2), 0.0)
    ideal = simulate_scan(world, at_start, SETTINGS.with_values({"lidar.n_beams": LD19.n_beams}).lidar)
    errors = (first.ranges - ideal.ranges)[np.isfinite(first.ranges - ideal.ranges)]
    assert abs(np.median(errors)) < 0.003
    assert np.percentile(abs(errors), 80) < 0.03


def test_the_ideal_lidar_is_cast_from_the_measured_pose_at_once(heard):
    run(**{"trial.timeout": 1.0})
    poses = {state.stamp: state for loop, state, _ in heard.poses if loop is ControllerLoop}
    scans = [scan for loop, scan, _ in heard.scans if loop is ControllerLoop]
    assert len(scans) > 15
    for scan in scans:
        ideal = simulate_scan(load_world("corridor"), poses[scan.stamp], SETTINGS.lidar)
        assert scan.ranges.tobytes() == ideal.ranges.tobytes()
        assert scan.time_increment == 0.0


def test_poses_in_bursts_are_stamped_at_receipt_and_repeated_ones_renewed_each_tenth_of_a_second(heard):
    """Both drive on: a burst is one pose of a velocity window, and a value that is repeated no new one."""
    for fault, joined in (("bursts", True), ("repeats", False)):
        heard.poses.clear()
        run(**{"simulator.mocap_fault": fault, "trial.timeout": 1.5})
        poses = [state for loop, state, _ in heard.poses if loop is ControllerLoop]
        gaps = np.diff([state.stamp for state in poses])
        assert gaps.max() > 0.045, fault
        assert ((gaps < 0.001).mean() > 0.5) == joined, fault
        assert max(np.hypot(*state.velocity) for state in poses) < 1.2 * SETTINGS.robot.max_speed, fault
        assert np.hypot(*(poses[-1].position - poses[0].position)) > 0.1, fault
