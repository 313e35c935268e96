"""The controller driven by hand: who commands, what stops a hand, and how the planner gets the robot back."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.command import FREE_SPACE, HAND, STOPPED
from collplan_core.control.hand import TAKEN
from collplan_core.control.interlock import REMEDY
from collplan_core.control.motion_monitor import STOPPING, MotionVerdict
from collplan_core.goal import EXECUTING, Goal
from collplan_core.loop.controller_loop import ControllerLoop
from loop_scenes import IDENTITY, SETTINGS, see, straight_plan

LIMITS = SETTINGS.limits
PERIOD = 1.0 / SETTINGS.controller.rate
LEFT = np.array([0.0, 0.3])
HELD = f"held: {TAKEN}; {REMEDY}"


class Drive:
    """A loop on its way to a goal, a period at a time, and the commands that it gave."""

    def __init__(self, setting=SETTINGS, goal=True) -> None:
        self.forbidden = ""
        self.loop, self.now, self.commands = ControllerLoop(setting, lambda: self.forbidden), 1.0, []
        self.seen = True
        if goal:
            self.give_goal(IDENTITY, 0.5)

    def give_goal(self, identity, stamp):
        self.loop.take_goal(Goal(identity, stamp, np.full(2, math.nan), EXECUTING))

    def period(self, velocity=None, yaw_rate=0.0, trouble=""):
        """One period with a command by hand, sent just now, or without one; the command that comes of it."""
        self.now += PERIOD
        if self.seen:
            see(self.loop, self.now)
            if self.loop.goal_active:
                assert self.loop.take_plan(straight_plan(self.now), self.now) == ""
        if velocity is not None:
            self.loop.take_hand(np.array(velocity), yaw_rate, self.now, trouble)
        self.commands.append(self.loop.tick(self.now))
        return self.commands[-1]

    def periods(self, n, velocity=None):
        for _ in range(n):
            command = self.period(velocity)
        return command


def test_a_hand_needs_no_pose_no_scan_no_goal_and_no_planner():
    drive = Drive(goal=False)
    drive.seen = False
    command = drive.periods(10, LEFT)
    assert (command.maneuver, command.reason) == (HAND, "")
    assert command.velocity == pytest.approx(LEFT)


def test_it_goes_before_the_planner_and_takes_over_without_a_jump():
    drive = Drive()
    assert drive.period().maneuver == FREE_SPACE
    drive.periods(12, LEFT)
    assert all(command.maneuver == HAND for command in drive.commands[1:])
    changes = np.diff([command.velocity for command in drive.commands], axis=0)
    assert np.hypot(*changes.T).max() <= SETTINGS.robot.max_acceleration * PERIOD + 1e-9
    assert drive.commands[-1].velocity == pytest.approx(LEFT)


def test_a_hand_that_lets_go_leaves_it_standing_until_a_person_gives_it_back():
    drive = Drive()
    drive.periods(3, LEFT)
    assert drive.period(np.zeros(2)).velocity.tolist() == [0.0, 0.0]
    assert drive.periods(40).reason == HELD
    assert drive.loop.goal_active
    drive.loop.resume()
    assert drive.period().maneuver == FREE_SPACE


def test_it_is_given_back_once_the_release_is_old():
    drive = Drive()
    drive.periods(3, LEFT)
    drive.period(np.zeros(2))
    drive.loop.resume()
    for _ in range(3):
        assert drive.period().velocity.tolist() == [0.0, 0.0]
    assert drive.periods(2).maneuver == FREE_SPACE


@settings(derandomize=True, deadline=None, max_examples=20)
@given(st.integers(1, 3), st.integers(1, 6), st.booleans())
def test_whatever_is_resumed_a_hand_that_rests_and_holds_on_keeps_the_robot_still(every, when, by_goal):
    """Its messages come in every so many periods."""
    drive = Drive()
    drive.periods(3, LEFT)
    for k in range(20):
        if k == when and by_goal:
            drive.give_goal(bytes(16), drive.now)
        elif k == when:
            drive.loop.resume()
        drive.period(np.zeros(2) if k % every == 0 else None)
    assert not any(command.velocity.any() for command in drive.commands[3:])
    assert drive.periods(10).reason == HELD


def test_a_hand_that_drives_keeps_the_robot_whatever_is_resumed():
    drive = Drive()
    drive.periods(3, LEFT)
    drive.loop.resume()
    assert drive.period().maneuver == HAND
    drive.give_goal(bytes(16), drive.now)
    assert drive.period().maneuver == HAND
    drive.period(np.zeros(2))
    assert drive.periods(10).reason == HELD


def test_a_new_goal_gives_it_back_too():
    drive = Drive()
    drive.periods(3, LEFT)
    drive.period(np.zeros(2))
    drive.give_goal(bytes(16), drive.now)
    assert drive.periods(5).maneuver == FREE_SPACE


def test_the_planner_holds_the_heading_that_a_hand_has_left():
    drive = Drive()
    drive.period()
    assert drive.loop._memory.heading is not None
    drive.period(np.zeros(2), 1.0)
    assert drive.loop._memory.heading is None
    drive.period(np.zeros(2))
    drive.loop.resume()
    command = drive.periods(5)
    assert (command.maneuver, command.yaw_rate) == (FREE_SPACE, 0.0)


@settings(derandomize=True, deadline=None, max_examples=30)
@given(st.floats(0.0, 0.6))
def test_a_hand_that_falls_silent_has_let_go(silence):
    drive = Drive()
    drive.periods(3, LEFT)
    later = drive.now + silence
    see(drive.loop, later)
    command = drive.loop.tick(later)
    if later - drive.now <= LIMITS.hand_age:
        assert command.maneuver == HAND
    else:
        assert command.reason == HELD


@pytest.mark.parametrize("reason", ["emergency stop by its service", "just started"])
def test_what_the_robot_says_of_itself_stops_a_hand(reason):
    drive = Drive()
    drive.periods(3, LEFT)
    drive.loop.take_robot_state(reason)
    assert drive.period(LEFT).reason == f"by hand: {reason}"
    assert drive.loop.hand_trouble == reason
    drive.loop.take_robot_state("")
    # from rest, as after any stop
    assert math.hypot(*drive.period(LEFT).velocity) == pytest.approx(SETTINGS.robot.max_acceleration * PERIOD)


def test_what_forbids_plans_stops_no_hand():
    drive = Drive()
    drive.forbidden = "planner heartbeat 0.23 s old, limit 0.20 s"
    assert drive.period().reason == drive.forbidden
    assert drive.period(LEFT).maneuver == HAND


def test_two_hands_stop_it_and_take_it_from_the_planner():
    drive = Drive()
    assert drive.period().maneuver == FREE_SPACE
    assert drive.period(LEFT, trouble="2 nodes publish").reason == "by hand: 2 nodes publish"
    assert drive.periods(10).reason == HELD


def test_what_is_no_command_stops_and_is_counted():
    drive = Drive()
    drive.periods(3, LEFT)
    assert drive.period([math.nan, 0.0]).reason.startswith("by hand: got nan")
    assert drive.loop.refusals["hand"] == 1
    assert drive.loop.hand_trouble.startswith("by hand: got nan")
    drive.periods(10)
    assert drive.loop.hand_trouble == ""


@pytest.mark.parametrize("fence", [(), (-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0)])
def test_where_poses_are_lost_it_creeps_or_stands_where_there_is_a_fence(fence):
    drive = Drive(SETTINGS.with_values({"limits.fence": fence}))
    fast = [1.0, 0.0]
    assert drive.periods(20, fast).velocity == pytest.approx(fast)
    drive.seen = False
    command = drive.periods(5, fast)
    if fence:
        assert command.reason == "by hand: not known to be within limits.fence: pose 0.25 s old, limit 0.15 s"
    else:
        assert command.velocity == pytest.approx([LIMITS.blind_speed, 0.0])
        assert drive.loop.hand_trouble == "pose 0.25 s old, limit 0.15 s"


@pytest.mark.parametrize("by_hand", [False, True])
@pytest.mark.parametrize("kind", STOPPING)
def test_once_the_motion_did_not_fit_the_commands_it_creeps_until_a_person_resumes(monkeypatch, kind, by_hand):
    drive, fast = Drive(), [1.0, 0.0]
    drive.periods(20, fast if by_hand else None)
    monkeypatch.setattr(drive.loop.motion, "judge", lambda *given: None)
    drive.loop.motion.verdict = MotionVerdict(kind, 0.3, "does not fit")
    drive.period(fast if by_hand else None)
    drive.loop.motion.verdict = MotionVerdict()
    for _ in range(20):
        assert math.hypot(*drive.period(fast).velocity) <= LIMITS.blind_speed + 1e-9
        assert drive.loop.hand_trouble == "does not fit"
    drive.loop.resume()
    assert drive.periods(20, fast).velocity == pytest.approx(fast)
    assert drive.loop.hand_trouble == ""


def test_outside_of_the_fence_it_stands():
    drive = Drive(SETTINGS.with_values({"limits.fence": (1.0, -1.0, 2.0, -1.0, 2.0, 1.0, 1.0, 1.0)}))
    assert drive.period(LEFT).reason == "by hand: the robot at 0.00, 0.00 is outside of limits.fence"


@settings(derandomize=True, deadline=None, max_examples=20)
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
    assert drive.periods(8).reason == HELD
