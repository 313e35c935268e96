"""What the planner decides, input by input, without a node; it plans with the straight planner of the tests."""

import re
from dataclasses import replace

import numpy as np
import pytest
from straight_planner import STRAIGHT

from collplan_core.control.permission import plan_lifetime
from collplan_core.deadline import never
from collplan_core.goal import ABORTED, ACCEPTED, CANCELED, EXECUTING
from collplan_core.loop import progress
from collplan_core.loop.decisions import ERROR, INFO, WARNING
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.loop.recovery import way_left
from collplan_core.movers.record import NO_MOVERS
from collplan_core.plan import NoPlan
from collplan_core.planners import PLANNERS
from loop_scenes import AHEAD, IDENTITY, SETTINGS, at, cycles, notices, scan_at, see, statuses

PERIOD = STRAIGHT.map_period
CHANGE = np.array([-0.5, 0.0])


@pytest.fixture(autouse=True)
def straight(monkeypatch):
    monkeypatch.setitem(PLANNERS, "custom", replace(STRAIGHT, replans_after_impact=True))


def with_goal(settings=SETTINGS, goal=AHEAD, why_forbidden=lambda: "") -> PlannerLoop:
    loop = PlannerLoop(settings, lambda settings: never, why_forbidden=why_forbidden)
    see(loop, 1.0)
    assert statuses(loop.take_goal(IDENTITY, goal, 1.0)) == [ACCEPTED]
    see(loop, 1.01)
    return loop


def test_a_plan_begins_at_the_newest_pose_and_says_how_long_it_holds():
    loop = with_goal()
    decisions = loop.cycle(1.02)
    (cycle,) = cycles(decisions)
    assert cycle.plan.stamp == 1.01
    assert cycle.plan.valid_until == pytest.approx(1.02 + plan_lifetime(PERIOD))
    np.testing.assert_allclose(cycle.plan.positions[[0, -1]], [[0.0, 0.0], AHEAD])
    assert statuses(decisions) == [EXECUTING]
    assert (loop.n_plans, loop.trouble) == (1, "")
    beyond, lasts = AHEAD + np.array([0.3, 0.4]), cycle.plan.times[-1] - 1.01
    assert way_left(cycle.plan, beyond, 0.25) == pytest.approx((np.hypot(*AHEAD) + 0.5, lasts + 2.0))


def test_no_plan_is_made_twice_of_one_pose_nor_of_one_before_the_goal():
    loop = PlannerLoop(SETTINGS, lambda settings: never)
    see(loop, 1.0)
    loop.take_goal(IDENTITY, AHEAD, 1.0)
    assert not cycles(loop.cycle(1.0))
    see(loop, 1.01)
    assert len(cycles(loop.cycle(1.01))) == 1
    assert not cycles(loop.cycle(1.02))


def test_cancel_ends_the_goal_once_and_so_does_one_that_is_refused():
    loop = with_goal()
    assert statuses(loop.cancel()) == [CANCELED]
    assert loop.cancel() == []
    loop = with_goal()
    decisions = loop.refuse_goal(bytes(16), "pose.position: nan")
    assert statuses(decisions) == [ABORTED]
    ((level, text),) = notices(decisions)
    assert (level, "nan" in text, loop.goal.active) == (ERROR, True, False)


def test_a_goal_inside_what_scans_show_is_given_up_not_for_a_single_scan():
    loop = with_goal(SETTINGS.with_values({"planner.goal_tolerance": 0.03}), goal=np.array([0.0, 0.47]))
    assert statuses(loop.cycle(1.02)) == []
    assert "cannot stand" in loop.trouble
    ended = []
    for stamp in np.arange(1.1, 1.2 + progress.CLOSED_OFF_TIME, 0.1).tolist():
        see(loop, stamp)
        ended += statuses(loop.cycle(stamp))
    assert ended == [ABORTED]
    assert "cannot stand" in loop.trouble


def drive_to_and_fro(loop: PlannerLoop, begin: float, end: float) -> list[str]:
    """Statuses of a goal while the robot drives over the same 0.5 m, from one length of its way to another [m]."""
    ended = []
    for k in range(round(begin / 0.1), round(end / 0.1)):
        place = 0.1 * (k % 10)
        stamp = 1.1 + 0.1 * k
        ended += statuses(see(loop, stamp, x=min(place, 1.0 - place)))
        ended += statuses(loop.cycle(stamp))
    return [status for status in ended if status != EXECUTING]


def test_a_goal_is_given_up_after_a_long_way_that_leads_no_nearer_by_a_planner_without_memory(monkeypatch):
    for limit, remembers, ends in ((3.0, False, True), (0.0, False, False), (3.0, True, False)):
        monkeypatch.setitem(PLANNERS, "custom", replace(STRAIGHT, gives_up_closed_off_goal=remembers))
        loop = with_goal(SETTINGS.with_values({"planner.longest_detour": limit}))
        assert drive_to_and_fro(loop, 0.0, 3.3) == []
        assert drive_to_and_fro(loop, 3.3, 3.8) == ([ABORTED] if ends else [])
    loop = with_goal(SETTINGS.with_values({"planner.longest_detour": 3.0}))
    drive_to_and_fro(loop, 0.0, 3.0)
    loop.take_goal(IDENTITY[::-1], np.array([2.5, 0.0]), 4.1)
    assert ABORTED not in drive_to_and_fro(loop, 3.0, 6.0)


def test_a_goal_not_reached_in_time_is_given_up_by_the_local_clock_also_where_it_is_given_again():
    for step in (0.0, 3600.0, -900.0):
        loop = with_goal(SETTINGS.with_values({"planner.goal_timeout": 1.0}))
        for local in np.arange(1.05, 2.0, 0.05).tolist():
            loop.take_pose(at(local + (step if local > 1.2 else 0.0)), local)
            if not step:
                loop.take_goal(IDENTITY[::-1], AHEAD, local)
            assert ABORTED not in statuses(loop.cycle(local)), step
        assert ABORTED in statuses(loop.cycle(2.01)), step
        assert "planner.goal_timeout" in loop.trouble
    loop.take_goal(IDENTITY, AHEAD, 2.1)
    assert ABORTED not in statuses(loop.cycle(3.05))


def failing(memory, local_map, state, goal, settings, deadline=never):
    raise NoPlan("aimless")


def test_trouble_is_said_once_when_it_begins_and_once_when_it_ends(monkeypatch):
    monkeypatch.setitem(PLANNERS, "custom", replace(STRAIGHT, plan=failing))
    loop = with_goal()
    ((level, text),) = notices(loop.cycle(1.02))
    assert (level, text.endswith("aimless")) == (WARNING, True)
    for stamp in (1.1, 1.2, 1.3):
        see(loop, stamp)
        assert loop.cycle(stamp) == []
    assert loop.refusals["no_plan"] == 4
    monkeypatch.setitem(PLANNERS, "custom", STRAIGHT)
    loop.change_settings(SETTINGS.with_values({"planner.strategy": "harness"}))
    loop.change_settings(SETTINGS)
    see(loop, 1.4)
    assert (INFO, "plans again") in notices(loop.cycle(1.4))


def test_a_goal_that_stays_closed_off_is_given_up_one_that_was_for_a_moment_is_not(monkeypatch):
    closing = replace(STRAIGHT, plan=failing, gives_up_closed_off_goal=True)
    monkeypatch.setitem(PLANNERS, "custom", closing)
    loop = with_goal()
    stamps = np.arange(1.02, 1.02 + progress.CLOSED_OFF_TIME + 0.3, 0.1).tolist()
    ended = []
    for stamp in stamps:
        see(loop, stamp)
        ended += [stamp for status in statuses(loop.cycle(stamp)) if status == ABORTED]
    assert len(ended) == 1
    assert ended[0] - 1.02 == pytest.approx(progress.CLOSED_OFF_TIME, abs=0.11)


def flickering(memory, local_map, state, goal, settings, deadline=never):
    if round(10.0 * state.stamp) % 8:
        raise NoPlan("closed off")
    return STRAIGHT.plan(memory, local_map, state, goal, settings, deadline)


def test_a_way_that_opens_and_closes_before_a_robot_that_stands_is_given_up_one_that_it_drives_on_is_not(monkeypatch):
    monkeypatch.setitem(PLANNERS, "custom", replace(STRAIGHT, plan=flickering, gives_up_closed_off_goal=True))
    for speed, by_hand, ends in ((0.0, False, 1), (0.1, False, 0), (0.0, True, 0)):
        loop, ended = with_goal(goal=np.array([2.9, 0.0])), []
        for stamp in np.arange(1.1, 2.0 + progress.PATIENCE, 0.1).tolist():
            see(loop, stamp, x=speed * stamp)
            if by_hand:
                loop.take_manual_command()
            ended += statuses(loop.cycle(stamp))
        assert ended.count(ABORTED) == ends, (speed, by_hand)
        assert not ends or re.search("stayed within .*closed off", loop.trouble)


def test_a_mover_beside_a_robot_that_stays_is_named_one_that_waits_for_no_one_or_is_held_may_stay():
    mover = replace(NO_MOVERS, positions=np.array([[0.5, 0.0]]), radii=np.array([0.2]))
    for movers, goal, driven, said in (
        (mover, AHEAD, True, "a mover, last seen at 0.50, 0.00"),
        (mover, np.array([0.6, 0.0]), True, "a mover on the goal"),
        (replace(mover, positions=np.array([[1.9, 0.0]])), AHEAD, True, ""),
        (NO_MOVERS, AHEAD, True, ""),
        (mover, AHEAD, False, ""),
    ):
        stays, found = progress.Progress(), ""
        for local in np.arange(0.0, progress.PATIENCE + 1.0, 0.05).tolist():
            found = found or stays.why_no_further(np.zeros(2), goal, movers, 1.0, local)
            stays.commanded(np.full(2, 0.1 * driven), local)
            stays.planned(local)
        assert (said in found) if said else not found, (said, found)


def test_time_in_which_no_scan_comes_closes_no_goal_off(monkeypatch):
    monkeypatch.setitem(PLANNERS, "custom", replace(STRAIGHT, plan=failing, gives_up_closed_off_goal=True))
    loop = with_goal()
    assert statuses(loop.cycle(1.02)) == []
    after = 1.2 + progress.CLOSED_OFF_TIME
    for local in np.arange(1.1, after - 0.05, 0.1).tolist():
        loop.take_pose(at(local), local)
        assert statuses(loop.cycle(local)) == []
    assert loop.why_stale(after).startswith("scan ")
    see(loop, after)
    assert statuses(loop.cycle(after)) == []
    assert loop.trouble == "aimless"


def test_plans_from_the_newest_pose_go_on_until_the_next_scan_of_a_slow_lidar():
    """A turn of 0.15 s, stamped with its first beam, is 0.31 s old when the next one comes 0.01 s after its end."""
    for sweep, until, limit in ((0.0, 1.24, ""), (0.0, 1.31, "0.25"), (0.15, 1.31, ""), (0.14, 1.40, "0.39")):
        loop = PlannerLoop(SETTINGS, lambda settings: never)
        loop.take_pose(at(0.8), 0.8)
        loop.take_goal(IDENTITY, AHEAD, 0.8)
        for k in range(1, round(100 * (until - 0.8)) + 1):
            stamp = 0.8 + 0.01 * k
            loop.take_pose(at(stamp), stamp)
            if k == 36:
                scan = scan_at(at(1.0))
                loop.take_scan(replace(scan, time_increment=sweep / (len(scan.ranges) - 1)), stamp)
        assert bool(cycles(loop.cycle(until))) == (not limit), (sweep, until)
        assert limit in loop.trouble, (sweep, until)
        assert limit or not loop.trouble, (sweep, until)


def test_a_reason_from_elsewhere_makes_no_plan_not_even_after_an_impact():
    reasons = [""]
    loop = with_goal(why_forbidden=lambda: reasons[-1])
    loop.cycle(1.02)
    reasons.append("robot.radius")
    see(loop, 1.05)
    assert notices(loop.take_impact(1.05, CHANGE, 1.05)) == [(WARNING, "no plan: robot.radius")]


def test_an_impact_is_planned_for_at_once_from_a_pose_that_is_as_late():
    loop = with_goal()
    loop.cycle(1.02)
    assert not cycles(loop.take_impact(1.05, CHANGE, 1.04))
    assert not cycles(see(loop, 1.04))
    (cycle,) = cycles(see(loop, 1.05))
    assert cycle.plan.stamp == 1.05
    assert not cycles(see(loop, 1.06))


def test_after_a_break_of_the_poses_the_goal_has_a_later_stamp_and_plans_go_on():
    loop = with_goal()
    loop.cycle(1.02)
    decisions = loop.take_pose(at(1.03, x=0.8), 1.03)
    assert statuses(decisions) == [EXECUTING]
    assert decisions[0].stamp == 1.03
    see(loop, 1.04, x=0.8)
    (cycle,) = cycles(loop.cycle(1.04))
    np.testing.assert_allclose(cycle.plan.positions[0], [0.8, 0.0])


def test_a_known_map_is_what_each_goal_begins_with(monkeypatch):
    seen = []

    def plan(memory, *arguments):
        seen.append(memory)
        return STRAIGHT.plan(0, *arguments)

    monkeypatch.setitem(PLANNERS, "custom", replace(STRAIGHT, plan=plan))
    loop = PlannerLoop(SETTINGS, lambda settings: never, known_map=41)
    for stamp in (1.0, 2.0):
        see(loop, stamp)
        loop.take_goal(IDENTITY, AHEAD, stamp)
        for later in (0.01, 0.02):
            see(loop, stamp + later)
            loop.cycle(stamp + later)
    assert seen == [41, 1, 41, 1]
