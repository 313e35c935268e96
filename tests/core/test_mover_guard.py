"""What the controller makes of movers: a planned command and a person's are slowed for them, and no robot is held."""

import math
from dataclasses import replace

import numpy as np
import pytest

from collplan_core.command import FREE_SPACE, HAND, WAITING, Command
from collplan_core.control.interlock import LONGEST_FAULT
from collplan_core.control.motion_monitor import OK
from collplan_core.goal import EXECUTING, Goal
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.mover_guard import kept_off
from collplan_core.loop.sensed_scans import SensedScans
from collplan_core.movers.record import NO_MOVERS, Movers
from collplan_core.state import State
from collplan_core.velocity_law import velocity_after, velocity_law
from collplan_core.worlds.raycast import simulate_scan
from loop_scenes import HALL, IDENTITY, SETTINGS, at, scan_at, straight_plan
from scenes import mover_at

PERIOD = 1.0 / SETTINGS.controller.rate
REACH = SETTINGS.robot.radius + 0.12
EMERGING = SETTINGS.with_values({"limits.emerging_speed": 0.5})


def mover(stamp, x, y=0.0, velocity=(0.0, 0.0)) -> Movers:
    return mover_at(x, y, velocity, stamp, growth=SETTINGS.movers.growth)


class Drive:
    """A robot that a loop drives along x at 0.5 m/s, by its law, among movers; commands, speeds and places along x."""

    def __init__(self, settings=SETTINGS) -> None:
        self.sensed = SensedScans(settings.limits.pose_history)
        self.loop, self.settings = ControllerLoop(settings, sensed=self.sensed), settings
        self.loop.take_goal(Goal(IDENTITY, 0.5, np.full(2, math.nan), EXECUTING))
        self.state, self.commands, self.speeds = at(1.0), [], []

    def period(self, movers=NO_MOVERS, hand=None) -> Command:
        state, now = self.state, self.state.stamp
        self.loop.take_pose(state, now)
        self.loop.take_scan(scan_at(state), now)
        plan = straight_plan(now)
        plan = replace(plan, positions=plan.positions + state.position)
        assert self.loop.take_plan(plan, now) == ""
        if hand is not None:
            self.loop.take_manual_command(np.array(hand), 0.0, now, "")
        self.sensed.movers = movers
        command = self.loop.tick(now)
        wheels = velocity_law(self.settings.robot)
        velocity = np.array(velocity_after(wheels, *state.velocity, *command.velocity, PERIOD))
        position = state.position + 0.5 * PERIOD * (state.velocity + velocity)
        self.state = State(now + PERIOD, position, velocity, 0.0)
        self.commands.append(command)
        self.speeds.append(velocity[0])
        return command

    def until(self, duration, movers=lambda stamp: NO_MOVERS, hand=None) -> Command:
        for _ in range(round(duration / PERIOD)):
            command = self.period(movers(self.state.stamp), hand)
        return command


def test_it_waits_in_front_of_a_mover_without_being_held_and_goes_on_when_that_has_gone():
    drive = Drive()
    drive.until(0.3)
    assert drive.commands[-1].reason == ""
    command = drive.until(3.0, lambda stamp: mover(stamp, 0.9))
    assert 0.9 - REACH - 0.25 < drive.state.position[0] < 0.9 - REACH - SETTINGS.movers.clearance + 0.01
    assert np.abs(drive.speeds[-10:]).max() < 0.05
    assert "a mover 0.1 m away" in command.reason or "a mover 0.0 m away" in command.reason
    assert len([each for each in drive.commands if each.maneuver == WAITING]) * PERIOD > LONGEST_FAULT
    assert (drive.loop.held, drive.loop.motion.verdict.kind) == ("", OK)
    assert drive.until(0.5).reason == ""
    assert drive.speeds[-1] > 0.3


def test_what_stands_aside_leaves_or_is_far_changes_no_bit():
    free = Drive()
    free.until(1.0)
    for movers in (
        lambda stamp: mover(stamp, 0.2, 0.45),
        lambda stamp: mover(stamp, 0.45 + 0.6 * (stamp - 1.0), velocity=(0.6, 0.0)),
        lambda stamp: mover(stamp, -0.3 + 0.4 * (stamp - 1.0), velocity=(0.4, 0.0)),
        lambda stamp: mover(stamp, 2.5),
    ):
        drive = Drive()
        drive.until(1.0, movers)
        for command, other in zip(drive.commands, free.commands, strict=True):
            np.testing.assert_array_equal(command.velocity, other.velocity)
            assert (command.maneuver, command.reason) == (other.maneuver, other.reason)


def test_by_hand_what_is_faster_than_the_blind_speed_is_checked():
    drive, slow = Drive(), SETTINGS.limits.blind_speed
    drive.until(1.0, hand=(0.9, 0.0))
    assert (drive.commands[-1].maneuver, drive.loop.override_trouble) == (HAND, "")
    x = drive.state.position[0]
    command = drive.until(0.5, lambda stamp: mover(stamp, x + 0.6), hand=(0.9, 0.0))
    assert command.maneuver == HAND
    assert "a mover" in drive.loop.override_trouble
    assert math.hypot(*command.velocity) == pytest.approx(slow, abs=0.1)
    x = drive.state.position[0]
    command = drive.until(0.2, lambda stamp: mover(stamp, x + 0.25), hand=(slow, 0.0))
    np.testing.assert_allclose(command.velocity, (slow, 0.0))
    assert drive.loop.override_trouble == ""


def test_what_may_come_out_of_what_it_does_not_see_slows_it_and_the_hall_does_not():
    hall, box = Drive(EMERGING), Drive(EMERGING)
    hall.until(1.0)
    assert all(command.reason == "" for command in hall.commands)
    state, around = box.state, []
    ranges = scan_at(state).ranges.copy()
    ranges[np.abs(scan_at(state).angles - 0.3) < 0.1] = 0.45
    for seen in (scan_at(state), replace(scan_at(state), ranges=ranges)):
        sensed = SensedScans(EMERGING.limits.pose_history)
        sensed.take_pose(state, 1.0, EMERGING)
        sensed.take_scan(seen, 1.0, EMERGING)
        around.append(sensed.newest_mapped(EMERGING))
    fast = replace(state, velocity=np.array([0.9, 0.0]))
    command = Command(np.array([0.9, 0.0]), 0.0, FREE_SPACE, np.zeros(2))
    assert kept_off(command, fast, NO_MOVERS, around[0], EMERGING) is command
    slowed = kept_off(command, fast, NO_MOVERS, around[1], EMERGING)
    assert math.hypot(*slowed.velocity) < 0.9
    assert "what it does not see" in slowed.reason
    assert kept_off(command, fast, NO_MOVERS, around[1], SETTINGS) is command


def test_what_no_scan_had_in_view_is_entered_slowly_by_avoid_alone_and_by_all_where_something_may_emerge():
    behind, state = Command(np.array([-1.0, 0.0]), 0.0, FREE_SPACE, np.zeros(2)), at(1.0)
    for degrees, strategy, emerging, slow in [
        (360, "avoid", 0.0, False),
        (270, "avoid", 0.0, True),
        (270, "stop_guarantee", 0.0, True),
        (270, "bounce", 0.0, False),
        (270, "harness", 0.0, False),
        (270, "bounce", 0.5, True),
    ]:
        wide = math.radians(degrees)
        settings = SETTINGS.with_values({"planner.strategy": strategy, "limits.emerging_speed": emerging})
        lidar = replace(settings.lidar, angle_min=-0.5 * wide, angle_span=wide)
        sensed = SensedScans(settings.limits.pose_history)
        sensed.take_pose(state, 1.0, settings)
        sensed.take_scan(simulate_scan(HALL, state, lidar), 1.0, settings)
        placed = sensed.newest_mapped(settings)
        sent = kept_off(behind, state, NO_MOVERS, placed, settings)
        assert (float(np.hypot(*sent.velocity)) <= 0.2) == slow, (degrees, strategy, sent)
        assert ("does not see" in sent.reason) == slow
        assert ("the LIDAR sees 270 of 360 degrees, controller.turns_to_look is false" in sent.reason) == slow
        ahead = replace(behind, velocity=np.array([0.5, 0.0]))
        assert emerging or kept_off(ahead, state, NO_MOVERS, placed, settings) is ahead
        by_hand = replace(behind, maneuver=HAND)
        assert emerging or kept_off(by_hand, state, NO_MOVERS, placed, settings) is by_hand
