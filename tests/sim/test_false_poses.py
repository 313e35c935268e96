"""Trials in which the motion capture turns, tips, lifts or swaps the robot: it is told to stand within 0.15 s."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from collplan_core.loop.controller_loop import ELSEWHERE, ControllerLoop
from collplan_core.parameters import Settings
from collplan_core.worlds import parse_world
from omnipuck_sim.robot.mocap_faults import faulty
from omnipuck_sim.robot.physics import Simulator
from omnipuck_sim.trial import run_trial

HALL = parse_world({"name": "hall", "bounds": [-1, -1, 6, 1], "start": [0.0, 0.0], "goal": [5.0, 0.0]}, "hall")
FAULT_AT = 1.2
LIMIT = 0.15


def run(monkeypatch, fault, strategy="avoid", lasts=math.inf):
    """Speed of each command, by time, of a run in a hall whose motion capture is at fault from FAULT_AT on.

    fault: a value of simulator.mocap_fault, or what it makes of a pose.
    """
    commands, wrong = [], fault if callable(fault) else partial(faulty, fault=fault)
    measure, tick = Simulator.measured_pose, ControllerLoop.tick

    def measured(self):
        sample = measure(self)
        return wrong(sample) if FAULT_AT <= self.time < FAULT_AT + lasts else sample

    def ticked(self, local):
        command = tick(self, local)
        commands.append((local, float(np.hypot(*command.velocity)), command.reason))
        return command

    monkeypatch.setattr(Simulator, "measured_pose", measured)
    monkeypatch.setattr(ControllerLoop, "tick", ticked)
    run_trial(HALL, Settings().with_values({"planner.strategy": strategy, "trial.timeout": 3.0}), seed=1)
    return commands


@pytest.mark.parametrize("fault", ["yaw_90", "yaw_180", "tilt", "lift"])
@pytest.mark.parametrize("strategy", ["avoid", "harness"])
def test_it_is_told_to_stand_in_time_and_for_as_long_as_it_lasts(monkeypatch, fault, strategy):
    commands = run(monkeypatch, fault, strategy)
    assert max(speed for time, speed, _ in commands if time < FAULT_AT) > 0.5
    later = [(speed, reason) for time, speed, reason in commands if time > FAULT_AT + LIMIT]
    assert len(later) > 20
    assert {speed for speed, _ in later} == {0.0}
    assert all(reason.startswith(("pose refused: ", "held: pose refused: ")) for _, reason in later)


def another_body(sample):
    return replace(sample, position=sample.position + np.array([1.5, 0.0]))


@pytest.mark.parametrize("strategy", ["avoid", "harness"])
def test_it_does_not_drive_on_by_the_poses_of_another_body(monkeypatch, strategy):
    commands = run(monkeypatch, another_body, strategy)
    assert max(speed for time, speed, _ in commands if time < FAULT_AT) > 0.5
    assert {speed for time, speed, _ in commands if time > FAULT_AT + LIMIT} == {0.0}
    assert commands[-1][2].startswith(f"held: {ELSEWHERE}")


def test_one_false_pose_alone_stops_nothing(monkeypatch):
    commands = run(monkeypatch, "yaw_180", lasts=0.009)
    assert all(speed > 0.0 for time, speed, _ in commands if 0.5 < time < 2.0)
