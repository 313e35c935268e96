"""What the controller decides, input by input, without a node."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.command import FREE_SPACE, STOPPED
from collplan_core.control.interlock import REMEDY, Interlock
from collplan_core.control.motion_monitor import LATE, OK, REVERSED, SLIP, STUCK, MotionVerdict
from collplan_core.goal import ABORTED, ACCEPTED, CANCELED, EXECUTING, NO_GOAL, SUCCEEDED, Goal
from collplan_core.loop.controller_loop import LONGEST_RESUMED, LONGEST_START, WHY_KIDNAPPED, ControllerLoop
from collplan_core.poses.pose_filter import KIDNAPPED
from collplan_core.state import State
from collplan_core.velocity_law import velocity_after, velocity_law
from loop_scenes import IDENTITY, SETTINGS, at, scan_at, see, see_until, straight_plan

LIMITS = SETTINGS.limits


def goal(status=EXECUTING, stamp=0.5, identity=IDENTITY) -> Goal:
    return Goal(identity, stamp, np.full(2, math.nan), status)


def test_where_no_wall_is_near_it_says_so_and_drives_no_faster_than_a_parameter():
    for wall, words, speed in ((True, "", 0.8), (False, "nothing vouches", LIMITS.unvouched_speed)):
        loop = ControllerLoop(SETTINGS)
        loop.take_goal(goal())
        loop.take_pose(at(1.0), 1.0)
        scan = scan_at(at(1.0))
        loop.take_scan(scan if wall else replace(scan, ranges=np.full(len(scan.ranges), np.inf)), 1.0)
        assert loop.take_plan(straight_plan(1.0, (1.6, 0.0)), 1.0) == ""
        command = loop.tick(1.0)
        assert words in command.reason
        np.testing.assert_allclose(command.velocity, (speed, 0.0), atol=0.01)


ENDED = [NO_GOAL, SUCCEEDED, CANCELED, ABORTED]


def driving(until: float | None = None, why_forbidden=lambda: "") -> ControllerLoop:
    """A loop that follows a plan along x of 1.0 s, told to be good until then."""
    loop = ControllerLoop(SETTINGS, why_forbidden)
    loop.take_goal(goal())
    see(loop, 1.0)
    assert loop.take_plan(replace(straight_plan(1.0), valid_until=until), 1.0) == ""
    command = loop.tick(1.0)
    assert (command.maneuver, command.reason) == (FREE_SPACE, "")
    np.testing.assert_allclose(command.velocity, (0.5, 0.0), atol=0.01)
    return loop


def test_it_starts_at_rest_and_names_what_lacks_first():
    loop = ControllerLoop(SETTINGS)
    lacking = [loop.tick(0.0)]
    loop.take_goal(goal())
    lacking.append(loop.tick(0.0))
    loop.take_pose(at(1.0), 1.0)
    lacking.append(loop.tick(1.0))
    see(loop, 1.1)
    lacking.append(loop.tick(1.1))
    for command, name in zip(lacking, ("goal", "pose", "scan", "plan"), strict=True):
        assert (command.maneuver, name in command.reason) == (STOPPED, True), name


@pytest.mark.parametrize("speed", [0.3, 0.9])
def test_a_constant_push_is_held_to_a_centimetre_beside_a_straight_path(speed):
    """A floor that leans or a weak wheel: 0.05 m/s to the side of what is commanded."""
    loop, wheels, period = ControllerLoop(SETTINGS), velocity_law(SETTINGS.robot), 0.01
    state, duration, aside = replace(at(1.0), velocity=np.array([speed, 0.0])), 2.5, []
    loop.take_goal(goal())
    for k in range(round(duration / period)):
        loop.take_pose(state, state.stamp)
        loop.take_scan(scan_at(state), state.stamp)
        if k == 0:
            plan = replace(straight_plan(1.0, (speed * duration, 0.0), duration), valid_until=9.0)
            assert loop.take_plan(plan, 1.0) == ""
        if k % 5 == 0:
            pushed = loop.tick(state.stamp).velocity + np.array([0.0, 0.05])
        velocity = np.array(velocity_after(wheels, *state.velocity, *pushed, period))
        position = state.position + 0.5 * period * (state.velocity + velocity)
        state = State(state.stamp + period, position, velocity, 0.0)
        aside.append(abs(position[1]))
    assert max(aside) < 0.014
    assert max(aside[round(1.5 / period) :]) < 0.01
    assert max(aside[-10:]) < 0.008


def test_the_end_of_the_goal_stops():
    for status in ENDED:
        loop = driving()
        loop.take_goal(goal(status))
        assert "goal" in loop.tick(1.0).reason
        assert "goal" in loop.take_plan(straight_plan(1.01), 1.01)
    loop = ControllerLoop(SETTINGS)
    without(loop, "pose", 1.0, 30.0)
    assert not loop.held  # without a goal nothing holds


@given(life=st.floats(0.05, 1.0), age=st.floats(0.0, 1.2))
def test_a_plan_is_followed_until_the_time_that_came_with_it(life, age):
    loop = driving(until=1.0 + life)
    see_until(loop, 1.0, 1.0 + age)
    command = loop.tick(1.0 + age)
    if age <= life - 1e-9:
        assert command.maneuver == FREE_SPACE
    elif age > life + 1e-9:
        assert command.reason.startswith("plan ")


def test_without_such_a_time_the_parameter_counts():
    loop = driving()
    see_until(loop, 1.0, 1.5)
    for age, follows in ((LIMITS.plan_age - 0.01, True), (LIMITS.plan_age + 0.01, False)):
        see(loop, 1.0 + age)
        assert (loop.tick(1.0 + age).maneuver == FREE_SPACE) == follows
    assert "0.61 s old" in loop.tick(1.0 + age).reason


def test_old_poses_and_scans_stop_it_and_refused_ones_are_named():
    for kind, refused, words in (
        ("pose", "", "pose 0.16 s old"),
        ("pose", "leap", "leap"),
        ("scan", "", "scan 0.31 s old"),
        ("scan", "odd frame", "odd frame"),
    ):
        loop = driving(until=9.0)
        if refused:
            loop.refuse(kind, refused)
        assert loop.tick(1.04).reason == ""
        for stamp in (1.1, 1.2, 1.31) if kind == "scan" else ():
            loop.take_pose(at(stamp), stamp)
        now = 1.31 if kind == "scan" else 1.16
        assert words in loop.tick(now).reason
        see(loop, now + 0.01)
        assert kind == "pose" or loop.tick(now + 0.01).reason == ""


def test_a_plan_waits_for_the_pose_it_begins_at():
    loop = ControllerLoop(SETTINGS)
    loop.take_goal(goal())
    see(loop, 1.0)
    assert "2.000" in loop.take_plan(straight_plan(2.0), 1.0)  # it begins too much later
    assert loop.take_plan(straight_plan(1.02), 1.0) == ""
    assert "plan" in loop.tick(1.0).reason
    see(loop, 1.04)
    assert loop.tick(1.04).maneuver == FREE_SPACE
    refused = loop.refusals["plan"]
    loop.take_plan(straight_plan(1.14), 1.04)
    loop.take_plan(straight_plan(1.04), 1.04)
    assert loop.refusals["plan"] == refused + 1  # one that was never adopted is refused by the next
    assert "1.140" in loop.refusals.newest


def test_a_leap_of_the_poses_drops_the_plan():
    loop = driving(until=9.0)
    see(loop, 1.01, x=0.5)
    assert "plan" in loop.tick(1.01).reason
    assert loop.refusals["pose_break"] == 1


def test_a_new_goal_refuses_the_plans_of_before():
    loop = driving(until=9.0)
    loop.take_goal(goal(ACCEPTED, stamp=1.0, identity=bytes(16)))
    assert "plan" in loop.tick(1.0).reason
    assert "1.000" in loop.take_plan(straight_plan(1.0), 1.0)
    see(loop, 1.02)
    assert loop.take_plan(straight_plan(1.02), 1.02) == ""
    assert loop.tick(1.02).maneuver == FREE_SPACE


def without(loop: ControllerLoop, missing: str, begin: float, duration: float) -> str:
    """Ticks for `duration` [s] from `begin` on while an input is missing; the last reason to stand still."""
    reason = ""
    for k in range(round(duration / 0.05) + 1):
        now = begin + 0.05 * k
        if missing != "pose":
            loop.take_pose(at(now), now)
        if missing != "scan":
            loop.take_scan(scan_at(at(now)), now)
        if missing != "plan" and loop.now(now) is not None:
            loop.take_plan(straight_plan(now), now)
        reason = loop.tick(now).reason
    return reason


def is_held(reason: str) -> bool:
    return reason.startswith("held: ")


INPUTS = ["pose", "scan", "plan"]


@pytest.mark.parametrize("missing", INPUTS)
def test_a_fault_of_over_a_second_holds_until_a_person_lets_it_go_on(missing):
    for freed in ("resume", "goal"):
        loop = driving()
        assert without(loop, missing, 1.05, 0.9)
        assert without(loop, "nothing", 2.0, 0.3) == ""  # a shorter one does not
        without(loop, missing, 2.35, 2.0)
        reason = without(loop, "nothing", 4.4, 3.0)
        assert reason.startswith(f"held: {missing} ")
        assert reason.endswith(REMEDY)
        loop.take_goal(replace(loop.goal, stamp=7.4))
        assert is_held(without(loop, "nothing", 7.45, 0.5))  # the same goal with another stamp is no new one
        if freed == "resume":
            loop.resume()
        else:
            loop.take_goal(goal(stamp=8.0, identity=bytes(16)))
        assert without(loop, "nothing", 8.05, 0.5) == ""


def test_a_plan_that_is_still_missing_after_resume_holds_it_again():
    loop = driving()
    without(loop, "plan", 1.05, 2.0)
    loop.resume()
    assert not is_held(without(loop, "plan", 3.1, LONGEST_RESUMED - 0.2))
    assert is_held(without(loop, "plan", 3.1 + LONGEST_RESUMED, 0.2))
    assert is_held(without(loop, "nothing", 3.4 + LONGEST_RESUMED, 1.0))


def leaps(loop: ControllerLoop, begin: float) -> None:
    for k in range(10):
        now = begin + 0.05 * k
        loop.take_scan(scan_at(at(now)), now)
        loop.refuse("pose", "leap: pose 1.000, 0.000")
        loop.tick(now)


def goes_on_elsewhere(loop: ControllerLoop, now: float, told_first: bool = True) -> str:
    told = "pose", f"{KIDNAPPED}: pose 1.000, 0.000"
    if told_first:
        loop.refuse(*told)
    see(loop, now, x=1.0)
    if not told_first:
        loop.refuse(*told)
    loop.take_goal(replace(loop.goal, stamp=now))
    see(loop, now + 0.05, x=1.0)
    loop.take_plan(straight_plan(now + 0.05), now + 0.05)
    return loop.tick(now + 0.05).reason


@pytest.mark.parametrize("told_first", [True, False])
def test_a_robot_that_was_carried_is_held_at_once_however_short_it_was_unseen(told_first):
    for freed in ("resume", "goal"):
        loop = driving()
        leaps(loop, 1.05)
        assert not loop.held
        held = f"held: {WHY_KIDNAPPED}; {REMEDY}"
        assert goes_on_elsewhere(loop, 1.55, told_first) == held
        assert without(loop, "nothing", 1.65, 1.0) == held
        if freed == "resume":
            loop.resume()
        else:
            loop.take_goal(goal(stamp=2.6, identity=bytes(16)))
        assert without(loop, "nothing", 2.7, 0.5) == ""
    loop = driving()
    leaps(loop, 1.05)
    assert without(loop, "nothing", 1.6, 0.3) == ""  # a leap that ends where it began holds nothing


def test_motion_that_is_late_or_reversed_holds_it_at_once_and_other_motion_does_not(monkeypatch):
    for kind, holds in ((LATE, True), (REVERSED, True), (STUCK, False), (SLIP, False)):
        loop, said = driving(until=9.0), [MotionVerdict(kind, 0.2, "misfit")]
        judged = monkeypatch.setattr
        judged(loop.motion, "judge", lambda *given, m=loop.motion, s=said: setattr(m, "verdict", s[-1]))
        assert loop.tick(1.0).reason == (f"held: misfit; {REMEDY}" if holds else "")
        said.append(MotionVerdict(OK))
        assert bool(loop.tick(1.0).reason) == bool(loop.held) == holds
        loop.resume()
        assert loop.tick(1.0).reason == ""


def test_goals_that_follow_one_another_on_the_way_forget_no_motion(monkeypatch):
    loop, forgot = driving(until=9.0), []
    monkeypatch.setattr(loop.motion, "forget", lambda: forgot.append(True))
    for k in range(3):
        loop.take_goal(goal(stamp=1.0, identity=bytes([k]) * 16))
    assert forgot == []
    assert is_held(without(loop, "pose", 1.1, 2.0))
    loop.take_goal(goal(stamp=3.1, identity=bytes([3]) * 16))
    assert forgot == [True]  # it was held
    loop.take_goal(goal(SUCCEEDED, stamp=3.1, identity=bytes([3]) * 16))
    loop.take_goal(goal(stamp=3.2, identity=bytes([4]) * 16))
    assert forgot == [True, True]  # it stood


def test_the_first_plan_of_a_goal_may_take_longer():
    loop = ControllerLoop(SETTINGS)
    first = goal()
    loop.take_goal(first)
    assert not is_held(without(loop, "plan", 1.0, 9.0))
    assert without(loop, "nothing", 10.05, 0.5) == ""
    loop.take_goal(goal(stamp=10.6, identity=bytes(16)))
    assert is_held(without(loop, "plan", 10.7, LONGEST_START + 0.5))
    loop.take_goal(replace(first, stamp=22.0))
    assert is_held(without(loop, "nothing", 22.1, 0.5))  # a goal heard of before lets nothing go on


@pytest.mark.parametrize("lost", ["pose", "scan", "heartbeat"])
def test_what_is_lost_for_over_a_second_holds_it_before_the_first_plan_too(lost):
    """A heartbeat is lost elsewhere, and forbids it to drive."""
    forbidden = [""]
    loop = driving(why_forbidden=lambda: forbidden[-1])

    def fault(begin, duration):
        forbidden.append(lost if lost == "heartbeat" else "")
        reason = without(loop, "plan" if lost == "heartbeat" else lost, begin, duration)
        forbidden.append("")
        return reason

    assert lost in fault(1.05, 0.4)
    loop.take_goal(goal(stamp=1.5, identity=bytes(16)))
    assert not is_held(without(loop, "plan", 1.55, 4.8))
    assert not is_held(fault(6.4, 0.8))
    assert not is_held(without(loop, "plan", 7.25, 0.5))
    assert is_held(fault(7.8, 1.4))
    assert is_held(without(loop, "nothing", 9.25, 2.0))


@given(st.lists(st.tuples(st.sampled_from([*INPUTS, "nothing"]), st.floats(0.05, 2.0)), max_size=6))
def test_once_held_no_course_of_inputs_moves_it(faults):
    loop, now = driving(), 1.05
    without(loop, "plan", now, 2.0)
    now += 2.1
    for missing, duration in faults:
        assert is_held(without(loop, missing, now, duration))
        now += duration + 0.1


FIRST, SECOND = bytes(16), bytes(range(16))


def test_the_first_goal_heard_of_may_be_one_of_before_and_the_next_is_new():
    held = Interlock("just started")
    assert not held.is_new(FIRST, active=True)
    known = held.after_goal(FIRST)
    assert known.reason == "just started"
    assert not known.is_new(FIRST, active=True)
    assert known.is_new(SECOND, active=True)
    assert not known.is_new(SECOND, active=False)
    lock = known.after_goal(SECOND).after_goal(FIRST)
    assert not lock.is_new(FIRST, active=True)
    assert not lock.is_new(SECOND, active=True)
    assert lock.held("a fault").reason
    assert not lock.held("a fault").resumed().reason
