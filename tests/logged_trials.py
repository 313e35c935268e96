"""Logs of trials in closed loop without ROS, with what a run folder knows of a simulated robot and of a real one."""

from dataclasses import replace

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.poses import pose_filter
from collplan_core.worlds import load_world
from collplan_ros.run.run_log import PoseRow, RunLog
from omnipuck_sim import trial


def logged_trial(world: str, settings: Settings, seed: int) -> RunLog:
    """The log of one trial with its truth; measured poses and detected impacts are those of the pose filter."""
    log, filter_pose = RunLog(), pose_filter.filter_pose

    def logged_filter(memory, sample, received, used):
        result, memory = filter_pose(memory, sample, received, used)
        if result.state is not None:
            log.poses.append(pose_row(result.state))
        if result.impact is not None:
            log.impacts.append(result.impact)
        return result, memory

    class LoggedRecord(trial.TrialRecord):
        def planned(self, plan, planning_time):
            super().planned(plan, planning_time)
            log.plans[plan.stamp] = plan.contacts

        def moved(self, truth, movers):
            super().moved(truth, movers)
            log.truth.append(pose_row(truth))

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(pose_filter, "filter_pose", logged_filter)
        patched.setattr(trial, "TrialRecord", LoggedRecord)
        result = trial.run_trial(load_world(world), settings, seed)
    log.impacts += result.impacts
    return log


def without_truth(log: RunLog) -> RunLog:
    """The same run as a real robot leaves it."""
    return replace(log, truth=[])


def pose_row(state) -> PoseRow:
    return PoseRow(state.stamp, *state.position.tolist(), state.yaw, *state.velocity.tolist(), state.stamp)


def pairs_of(detected_times: np.ndarray, true_times: np.ndarray, farthest: float) -> list[tuple[int, int]]:
    """Indices of each detected impact and of the true one nearest to it in time, at most `farthest` [s] away, once."""
    pairs, left = [], set(range(len(true_times)))
    for i, time in enumerate(detected_times.tolist()):
        nearest = min(left, key=lambda j: abs(true_times[j] - time), default=None)
        if nearest is not None and abs(true_times[nearest] - time) <= farthest:
            pairs.append((i, nearest))
            left.remove(nearest)
    return pairs
