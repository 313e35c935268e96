"""Trials in which the motion capture turns, tips or swaps the robot: it is commanded to stand within 0.15 s."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from collplan_core.loop.controller_loop import ELSEWHERE
from collplan_core.parameters import Settings
from collplan_core.worlds import parse_world
from omnipuck_sim.robot.mocap_faults import faulty
from omnipuck_sim.robot.physics import Simulator
from omnipuck_sim.trial import run_trial
from omnipuck_sim.trial_record import TrialRecord

HALL = parse_world({"name": "hall", "bounds": [-1, -1, 6, 1], "start": [0.0, 0.0], "goal": [5.0, 0.0]}, "hall")
FAULT_AT = 1.2
LIMIT = 0.15


def another_body(sample):
    return replace(sample, position=sample.position + np.array([1.5, 0.0]))


def run(monkeypatch, fault, strategy="avoid", lasts=math.inf):
    """Time, speed and reason of each command of a run in a hall whose motion capture is at fault from FAULT_AT on.

    fault: what it makes of a pose.
    """
    commands = []
    measure, commanded = Simulator.measured_pose, TrialRecord.commanded

    def measured(self):
        sample = measure(self)
        return fault(sample) if FAULT_AT <= self.time < FAULT_AT + lasts else sample

    def listening(self, command, now):
        commands.append((now, float(np.hypot(*command.velocity)), command.reason))
        commanded(self, command, now)

    monkeypatch.setattr(Simulator, "measured_pose", measured)
    monkeypatch.setattr(TrialRecord, "commanded", listening)
    run_trial(HALL, Settings().with_values({"planner.strategy": strategy, "trial.timeout": 2.5}), seed=1)
    return commands


@pytest.mark.parametrize(
    ("fault", "strategy", "why"),
    [
        (partial(faulty, fault="yaw_90"), "avoid", "pose refused"),
        (partial(faulty, fault="tilt"), "harness", "pose refused"),
        (partial(faulty, fault="lift"), "harness", "pose refused"),
        (another_body, "avoid", ELSEWHERE),
    ],
)
def test_it_stands_in_time_and_for_as_long_as_it_lasts(monkeypatch, fault, strategy, why):
    commands = run(monkeypatch, fault, strategy)
    assert max(speed for time, speed, _ in commands if time < FAULT_AT) > 0.5
    later = [(speed, reason) for time, speed, reason in commands if time > FAULT_AT + LIMIT]
    assert len(later) > 15
    assert {speed for speed, _ in later} == {0.0}
    assert why in later[-1][1]


def test_one_false_pose_alone_stops_nothing(monkeypatch):
    commands = run(monkeypatch, partial(faulty, fault="yaw_180"), lasts=0.009)
    assert all(speed > 0.0 for time, speed, _ in commands if 0.5 < time < 2.0)
