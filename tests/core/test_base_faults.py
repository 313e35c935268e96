"""A base that follows other commands than it is given is named; one with an unknown lag, delay or load is not."""

import math

import numpy as np
import pytest

from collplan_core.control.base_faults import BaseFaults
from collplan_core.control.drive_record import DriveRecord
from collplan_core.parameters import Robot
from collplan_core.plane import rotate
from collplan_core.state import State
from collplan_core.velocity_law import VelocityLaw, velocity_after_step

YAW, PERIOD = 0.7, 0.02
TOLD = np.random.default_rng(3).uniform(-1.0, 1.0, (9, 2))  # 1.2 s each, up to 1.03 m/s
FREE = VelocityLaw(1.5, 0.1, PERIOD, math.exp(-PERIOD / 0.1))


def said_of(follows, commands=TOLD, law=FREE, late=0):
    faults, v, sent = BaseFaults(Robot()), (0.0, 0.0), []
    drive = DriveRecord().with_pose(State(0.0, np.zeros(2), np.zeros(2), YAW), 0.0)
    noise = np.random.default_rng(5).normal(0.0, 0.03, (len(commands) * 60, 2))
    for k, off in enumerate(noise):
        told = commands[k // 60]
        sent.append(follows(told))
        drive = drive.with_command(told, PERIOD * k)
        v = velocity_after_step(law, *v, *sent[max(k - late, 0)])
        state = State(PERIOD * (k + 1), np.zeros(2), np.array(rotate(*(v + off), YAW)), YAW)
        drive = drive.with_pose(state, state.stamp)
        faults.take_pose(drive, free=True)
    return faults.why_unlike


def slower(limit):
    return lambda told: told * min(1.0, limit / np.hypot(*told))


@pytest.mark.parametrize(
    ("follows", "named"),
    [
        (lambda told: told * (1.0, 0.0), "moves along x alone: can the base drive sideways?"),
        (lambda told: told * 0.0, ""),
        (slower(0.4), "of 1.03 m/s commanded: another limit?"),
        (slower(0.6), "of 1.03 m/s commanded: another limit?"),
        (slower(1.0), ""),
        (lambda told: 1.1 * told, "moves 1.1 m for each metre commanded: do poses or wheels count right?"),
        (lambda told: 0.9 * told, "moves 0.9 m for each metre commanded"),
        (lambda told: np.add(told, (0.04, -0.04)), ""),
        (lambda told: told * (1.0, -1.0), ""),
    ],
)
def test_another_base_is_named(follows, named):
    said = said_of(follows)
    assert named in said
    assert bool(said) == bool(named)


def test_a_base_that_ignores_slow_commands_is_named():
    said = said_of(lambda told: told * (np.hypot(*told) > 0.2), np.vstack([TOLD[:5], 0.3 * TOLD]))
    assert said.startswith("stands at commands below 0.2 m/s")


@pytest.mark.parametrize(
    ("acceleration", "lag", "late"), [(0.5, 0.2, 5), (3.0, 0.03, 0), (1.5, 0.3, 0), (1.5, 0.1, 10)]
)
def test_a_base_of_another_drive_is_right(acceleration, lag, late):
    law = VelocityLaw(acceleration, lag, PERIOD, math.exp(-PERIOD / lag))
    assert said_of(lambda told: told, law=law, late=late) == ""
