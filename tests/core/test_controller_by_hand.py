"""The controller driven by hand: who commands, what stops a hand, how the planner gets the robot back."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.command import FREE_SPACE, HAND, STOPPED, Command
from collplan_core.control.follow import saturate
from collplan_core.control.interlock import REMEDY
from collplan_core.control.manual_override import TAKEN, ManualCommand, overriding_command
from collplan_core.control.motion_monitor import STOPPING, MotionVerdict
from collplan_core.goal import EXECUTING, Goal
from collplan_core.loop.controller_loop import ControllerLoop
from loop_scenes import IDENTITY, SETTINGS, at, scan_at, see, straight_plan

LIMITS = SETTINGS.limits
PERIOD = 1.0 / SETTINGS.controller.rate
LEFT = np.array([0.0, 0.3])


class Drive:
    """A loop on its way to a goal, a period at a time, and the commands that it gave."""

    def __init__(self, setting=SETTINGS, goal=True) -> None:
        self.forbidden = ""
        self.loop, self.now, self.commands = ControllerLoop(setting, lambda: self.forbidden), 1.0, []
        self.seen, self.yaw = True, 0.0
        if goal:
            self.give_goal(IDENTITY, 0.5)

    def give_goal(self, identity, stamp):
        self.loop.take_goal(Goal(identity, stamp, np.full(2, math.nan), EXECUTING))

    def give_back(self, by_goal=False):
        if by_goal:
            self.give_goal(bytes(16), self.now)
        else:
            self.loop.resume()

    def period(self, velocity=None, yaw_rate=0.0, trouble=""):
        """One period with a command by hand, sent just now, or without one; the command that comes of it."""
        self.now += PERIOD
        if self.seen:
            state = replace(at(self.now), yaw=self.yaw)
            self.loop.take_pose(state, self.now)
            self.loop.take_scan(scan_at(state), self.now)
            if self.loop.goal_active:
                assert self.loop.take_plan(straight_plan(self.now), self.now) == ""
        if velocity is not None:
            self.loop.take_manual_command(np.array(velocity), yaw_rate, self.now, trouble)
        self.commands.append(self.loop.tick(self.now))
        return self.commands[-1]

    def periods(self, n, velocity=None):
        for _ in range(n):
            command = self.period(velocity)
        return command


def driven_by_hand() -> Drive:
    drive = Drive()
    drive.periods(3, LEFT)
    return drive


def is_held(command) -> bool:
    return TAKEN in command.reason and REMEDY in command.reason and not command.velocity.any()


def test_a_hand_needs_no_pose_no_scan_no_goal_and_no_planner():
    drive = Drive(goal=False)
    drive.seen = False
    command = drive.periods(10, LEFT)
    assert (command.maneuver, command.reason) == (HAND, "")
    assert command.velocity == pytest.approx(LEFT)


def test_it_goes_before_the_planner_and_takes_over_without_a_jump():
    drive = Drive()
    assert drive.period().maneuver == FREE_SPACE
    drive.forbidden = "no heartbeat"
    assert drive.periods(12, LEFT).velocity == pytest.approx(LEFT)
    assert all(command.maneuver == HAND for command in drive.commands[1:])  # what forbids plans forbids no hand
    changes = np.diff([command.velocity for command in drive.commands], axis=0)
    assert np.hypot(*changes.T).max() <= SETTINGS.robot.max_acceleration * PERIOD + 1e-9


def test_a_hand_that_lets_go_leaves_it_standing_until_a_person_gives_it_back():
    for by_goal in (False, True):
        drive = driven_by_hand()
        assert not drive.period(np.zeros(2)).velocity.any()
        assert is_held(drive.periods(40))
        assert drive.loop.goal_active
        drive.give_back(by_goal)
        assert drive.period().maneuver == FREE_SPACE
        drive.period(LEFT)
        drive.period(np.zeros(2))
        drive.loop.resume()
        assert not any(drive.period().velocity.any() for _ in range(3))
        assert drive.periods(2).maneuver == FREE_SPACE


@given(st.integers(1, 3), st.integers(1, 6), st.booleans(), st.booleans())
def test_whatever_is_resumed_a_hand_that_holds_on_keeps_the_robot_driving_or_at_rest(every, when, by_goal, rests):
    drive = driven_by_hand()
    for k in range(20):
        if k == when:
            drive.give_back(by_goal)
        command = drive.period((0.0 if rests else 1.0) * LEFT if k % every == 0 else None)
        assert command.velocity.any() != rests
        assert rests or command.maneuver == HAND
    assert is_held(drive.periods(10))


def test_the_planner_holds_the_heading_that_a_hand_has_left():
    drive = Drive()
    drive.period()
    drive.period(np.zeros(2), 1.0)
    drive.yaw = 1.0
    drive.period(np.zeros(2))
    drive.loop.resume()
    command = drive.periods(5)
    assert (command.maneuver, command.yaw_rate) == (FREE_SPACE, 0.0)


@given(st.floats(0.0, 0.6))
def test_a_hand_that_falls_silent_has_let_go(silence):
    drive = driven_by_hand()
    later = drive.now + silence
    see(drive.loop, later)
    command = drive.loop.tick(later)
    assert (command.maneuver == HAND) == (later - drive.now <= LIMITS.hand_age)
    assert is_held(command) == (command.maneuver != HAND)


def test_what_the_robot_says_of_itself_stops_a_hand_and_the_planner():
    drive = Drive()
    drive.loop.take_robot_state("emergency stop")
    assert "emergency stop" in drive.period().reason
    drive = driven_by_hand()
    drive.loop.take_robot_state("emergency stop")
    stop = drive.period(LEFT)
    assert (stop.maneuver, "emergency stop" in stop.reason) == (STOPPED, True)
    assert drive.loop.override_trouble == "emergency stop"
    drive.loop.take_robot_state("")
    # from rest, as after any stop
    assert math.hypot(*drive.period(LEFT).velocity) == pytest.approx(SETTINGS.robot.max_acceleration * PERIOD)


def test_what_is_no_command_stops_and_is_counted_and_two_hands_stop_too():
    drive = driven_by_hand()
    assert drive.period([math.nan, 0.0]).maneuver == STOPPED
    assert "nan" in drive.loop.override_trouble
    assert drive.loop.refusals["hand"] == 1
    drive.periods(10)
    assert drive.loop.override_trouble == ""
    drive = Drive()
    drive.period()
    assert "two nodes" in drive.period(LEFT, trouble="two nodes").reason
    assert is_held(drive.periods(10))


def test_where_poses_are_lost_it_creeps_or_stands_where_there_is_a_fence_as_it_does_outside_of_one():
    fast = [1.0, 0.0]
    for fence in ((), (-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0)):
        drive = Drive(SETTINGS.with_values({"limits.fence": fence}))
        assert drive.periods(20, fast).velocity == pytest.approx(fast)
        drive.seen = False
        command = drive.periods(5, fast)
        assert command.velocity == pytest.approx([0.0 if fence else LIMITS.blind_speed, 0.0])
        assert "pose 0.25 s old" in (command.reason if fence else drive.loop.override_trouble)
    drive = Drive(SETTINGS.with_values({"limits.fence": (1.0, -1.0, 2.0, -1.0, 2.0, 1.0, 1.0, 1.0)}))
    assert "outside" in drive.period(LEFT).reason


@pytest.mark.parametrize("by_hand", [False, True])
def test_once_the_motion_did_not_fit_the_commands_it_creeps_until_a_person_resumes(monkeypatch, by_hand):
    for kind in STOPPING:
        drive, fast = Drive(), [1.0, 0.0]
        drive.periods(20, fast if by_hand else None)
        monkeypatch.setattr(drive.loop.motion, "judge", lambda *given: None)
        drive.loop.motion.verdict = MotionVerdict(kind, 0.3, "misfit")
        drive.period(fast if by_hand else None)
        drive.loop.motion.verdict = MotionVerdict()
        for _ in range(20):
            assert math.hypot(*drive.period(fast).velocity) <= LIMITS.blind_speed + 1e-9
            assert drive.loop.override_trouble == "misfit"
        drive.loop.resume()
        assert drive.periods(20, fast).velocity == pytest.approx(fast)
        assert drive.loop.override_trouble == ""


@given(st.lists(st.sampled_from(["drives", "rests", "nothing", "no pose"]), min_size=1, max_size=10))
def test_once_a_hand_has_had_it_no_planner_moves_it_unasked(course):
    drive = Drive()
    drive.period()
    drive.period(LEFT)
    for step in course:
        drive.seen = step != "no pose"
        command = drive.period({"drives": LEFT, "rests": np.zeros(2)}.get(step))
        assert command.maneuver in (HAND, STOPPED)
    drive.seen = True
    assert is_held(drive.periods(8))


ROBOT = SETTINGS.robot
speeds = st.floats(-ROBOT.max_speed, ROBOT.max_speed)
velocities = st.tuples(speeds, speeds).map(lambda pair: saturate(np.array(pair), ROBOT.max_speed))
rates = st.floats(-ROBOT.max_yaw_rate, ROBOT.max_yaw_rate)


def hand(x=0.0, y=0.0, yaw_rate=0.0) -> ManualCommand:
    return ManualCommand(np.array([x, y]), yaw_rate, 1.0, "")


def sent(velocity, yaw_rate=0.0) -> Command:
    return Command(np.array(velocity), yaw_rate, HAND, np.full(2, np.nan))


@given(velocities, rates, velocities, rates, st.booleans())
def test_a_command_goes_from_the_one_before_as_wheels_can_within_the_limits_or_to_rest_at_once(
    before, turning, wanted, turn, is_blind
):
    command = overriding_command(ManualCommand(wanted, turn, 0.0), sent(before, turning), is_blind, SETTINGS)
    if command.velocity.any() and not is_blind:
        assert math.hypot(*(command.velocity - before)) <= ROBOT.max_acceleration * PERIOD + 1e-9
    if command.yaw_rate:
        assert abs(command.yaw_rate - turning) <= ROBOT.max_acceleration / ROBOT.radius * PERIOD + 1e-9
    most = min(LIMITS.blind_speed, ROBOT.max_speed) if is_blind else ROBOT.max_speed
    assert math.hypot(*command.velocity) <= most + 1e-9
    assert abs(command.yaw_rate) <= ROBOT.max_yaw_rate + 1e-9
    rest = overriding_command(hand(), sent(before, turning), False, SETTINGS)
    assert (rest.velocity.any(), rest.yaw_rate) == (False, 0.0)


def test_by_hand_a_turn_to_the_side_at_speed_and_what_is_no_command():
    command = overriding_command(hand(0.0, 0.3), sent([1.0, 0.0]), False, SETTINGS)
    change = np.array([-1.0, 0.3]) / math.hypot(1.0, 0.3) * 0.075
    assert command.velocity == pytest.approx(np.array([1.0, 0.0]) + change)
    for broken in (hand(0.1, math.inf), hand(0.1, yaw_rate=math.nan)):
        command = overriding_command(broken, sent([0.3, 0.0]), False, SETTINGS)
        assert (command.maneuver, command.velocity.tolist(), command.yaw_rate) == (STOPPED, [0.0, 0.0], 0.0)
