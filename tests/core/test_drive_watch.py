"""The learnt drive in the loops: which poses count, and that planner and controller use one drive."""

from dataclasses import replace

import numpy as np
import pytest

from collplan_core.command import FREE_SPACE, Command, stopped
from collplan_core.control.drive_record import DriveRecord
from collplan_core.control.motion_monitor import LATE, OK, SLIP
from collplan_core.goal import EXECUTING, Goal
from collplan_core.learning.drive import Drive, drive_of
from collplan_core.loop import controller_loop
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.drive_watch import SURE, DriveWatch
from collplan_core.state import State
from loop_scenes import IDENTITY, SETTINGS, see, straight_plan

HEAVY = Drive(0.75, 0.2, 0.03)
BELIEF = drive_of(SETTINGS.robot)


def test_a_plan_is_followed_with_the_drive_that_it_was_made_with(monkeypatch):
    followed_with, follow = [], controller_loop.follow
    monkeypatch.setattr(
        controller_loop, "follow", lambda *given: followed_with.append(drive_of(given[-1].robot)) or follow(*given)
    )
    loop = ControllerLoop(SETTINGS)
    loop.take_goal(Goal(IDENTITY, 0.5, np.full(2, np.nan), EXECUTING))
    for stamp, drive in ((1.0, HEAVY), (1.1, None), (1.2, list(HEAVY))):
        see(loop, stamp)
        assert loop.take_plan(replace(straight_plan(stamp), drive=drive), stamp) == ""
        assert loop.tick(stamp).maneuver == FREE_SPACE
    assert followed_with == [HEAVY, BELIEF, HEAVY]


def driven(
    settings=SETTINGS, kind=OK, robot_stands="", makes_command=None, pushed=False, hit=None, refused=False, steps=600
):
    """A watch of a robot that starts at 0.75 m/s^2; `hit` is a change and whether a surface is near, each 0.1 s."""
    watch, drive, random, x, v = DriveWatch(settings), DriveRecord(), np.random.default_rng(1), 0.0, 0.0
    for k in range(steps):
        now, wanted = 0.01 * k, 1.0 if k % 200 < 100 else -1.0
        position = np.array([x, 0.0]) + random.normal(0.0, 0.002, 2)
        drive = drive.with_pose(State(now, position, np.array([v, 0.0]), 0.0), now)
        watch.take_pose(drive, True, pushed)
        if hit is not None and k % 10 == 9:
            watch.take_impact(now, np.array([hit[0], 0.0]), hit[1])
        if refused and k % 20 == 0:
            watch.refuse_pose()
        if k % 5 == 0:
            command = makes_command or Command(np.array([wanted, 0.0]), 0.0, FREE_SPACE, np.zeros(2))
            drive = drive.with_command(command.velocity, now)
            watch.commanded(command, now, kind, robot_stands)
        change = 0.01 * np.clip((wanted - v) / 0.1, -0.75, 0.75)
        x, v = x + 0.01 * (v + 0.5 * change), v + change
    return watch


def test_the_drive_is_learnt_and_used():
    watch = driven()
    assert watch.in_use.max_acceleration == pytest.approx(0.75, rel=0.04)
    assert watch.learnt.why_unlike(BELIEF) == f"drives like {watch.learnt.max_acceleration.value:.2f} m/s^2, set to 1.5"


def test_an_impact_far_from_all_walls_that_another_drive_may_make_costs_no_pose():
    assert driven(hit=(0.9 * SURE, False)).in_use.max_acceleration == pytest.approx(0.75, rel=0.04)


@pytest.mark.parametrize(
    "conditions",
    [
        {"robot_stands": "held"},
        {"kind": SLIP},
        {"kind": LATE},
        {"steps": 120},
        {"makes_command": stopped("no active goal")},
        {"pushed": True},
        {"hit": (0.5 * SURE, True)},
        {"hit": (1.1 * SURE, False)},
        {"refused": True},
    ],
)
def test_nothing_is_used_of_what_is_not_the_wheels_work_and_before_there_is_enough_of_it(conditions):
    assert driven(**conditions).in_use == BELIEF


def test_without_learning_there_is_no_drive():
    watch = driven(SETTINGS.with_values({"robot.learning": "off"}))
    assert (watch.in_use, watch.learnt) == (None, None)
