"""planner_node with the time-to-goal strategies: from the newest pose, at once after a hit, up to a closed-off goal."""

import time

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from rclpy.parameter import Parameter
from std_msgs.msg import Empty

from collplan_core.deadline import never
from collplan_core.loop import current_goal
from collplan_core.loop.planner_loop import ALARM_PERIODS
from collplan_core.worlds import parse_world
from collplan_ros.messages.conversions import impact_to_message, seconds_from_stamp
from collplan_ros.messages.qos import EVENT
from collplan_ros.messages.reading import plan_from_path
from collplan_ros.nodes import planner_node
from collplan_ros.nodes.planner_node import BUDGET_SHARE
from fake_robot import PERIOD, SCAN_EVERY, hall
from planner_bench import AHEAD, PlannerBench

CHANGE = np.array([-0.5, 0.0])
QUICK = {"time_to_goal__start_proposals": 10, "time_to_goal__proposals": 10}
SCATTER = 0.15
"""Largest difference in duration of two plans from rest that were refined by few proposals each [s]."""
SELDOM = 2.0
"""A map_period in which no plan is due while a test looks on [s]."""


def rolling(ros, world=None, strategy="bounce", **parameters):
    return PlannerBench(ros, world, planner__strategy=strategy, **QUICK, **parameters)


@pytest.fixture
def bench(ros):
    return rolling(ros)


@pytest.fixture
def idle(ros):
    """A bench with a goal and a plan, whose next plan is long due, and a way to tell of hits."""
    bench = rolling(ros, limits__pose_age=0.5)
    bench.impacts = ros.publisher(Vector3Stamped, "impact", EVENT)
    wait_for_idleness(bench)
    return bench


def wait_for_idleness(bench):
    bench.send_goal()
    bench.wait_for_plan()
    bench.node.set_parameters([Parameter("planner.map_period", value=SELDOM)])
    bench.ros.spin(0.1)  # the period before may still be running


def tell(bench, stamp):
    """A hit at this stamp, taken by the node before this returns."""
    heard = bench.node._loop.n_impacts
    bench.impacts.publish(impact_to_message(stamp, CHANGE, "map"))
    assert bench.ros.wait_until(lambda: bench.node._loop.n_impacts > heard)


def stamps(bench):
    return [seconds_from_stamp(plan.header.stamp) for plan in bench.plans]


def test_plans_begin_at_the_newest_pose_whether_it_has_a_scan_or_not(ros, bench):
    bench.send_goal()
    assert ros.wait_until(lambda: len(bench.plans) >= 6)
    ticks = np.array([(stamp - 100.0) / PERIOD for stamp in stamps(bench)])
    np.testing.assert_allclose(ticks, np.rint(ticks), atol=1e-4)
    assert np.any(np.rint(ticks) % SCAN_EVERY != 0)
    plan = plan_from_path(bench.plans[0], "map")
    assert plan.times[0] == pytest.approx(plan.stamp, abs=2e-9)
    np.testing.assert_allclose(plan.positions[0], bench.robot.position, atol=1e-9)
    assert np.hypot(*(plan.positions[-1] - AHEAD)) <= 0.1 + 1e-6


def test_without_new_scans_plans_go_on_until_the_last_is_too_old(ros):
    bench = rolling(ros, limits__scan_age=0.5)
    bench.send_goal()
    bench.wait_for_plan()
    bench.robot.scans_on = False
    now = bench.node._loop._placed.scan.stamp
    assert ros.wait_until(lambda: [s for s in stamps(bench) if s > now + 0.2])
    bench.wait_for_count("refused_stale")
    bench.assert_no_more_plans()
    # one more scan may have been under way when they were switched off
    last = bench.node._loop._placed.scan.stamp
    assert max(stamps(bench)) <= last + 0.5 + 1e-6


def test_scans_that_no_pose_belongs_to_are_no_use(ros, bench):
    bench.send_goal()
    bench.wait_for_plan()
    bench.robot.scans_on = False
    early = bench.robot.scan()
    early.header.stamp.sec += 5
    # fresh by receipt, all the time
    ros.probe.create_timer(0.05, lambda: bench.robot.scans.publish(early))
    assert ros.wait_until(lambda: bench.node._loop.refusals["scan"] > 10)
    bench.assert_no_more_plans()


def test_a_hit_is_planned_for_at_once_from_a_pose_that_knows_of_it(ros, idle):
    before, hit = len(idle.plans), idle.robot.stamp
    tell(idle, hit)
    assert ros.wait_until(lambda: len(idle.plans) > before)
    assert hit - 1e-6 <= stamps(idle)[before] < hit + 0.5 * SELDOM
    assert idle.value("impacts") == "1"


def test_a_hit_waits_for_the_pose_that_knows_of_it(ros, idle):
    idle.robot.poses_on = False
    ros.spin(2 * PERIOD)
    before, hit = len(idle.plans), idle.node._loop._sensors.state.stamp + 0.2
    tell(idle, hit)
    ros.spin(0.1)
    assert len(idle.plans) == before
    idle.robot.poses_on = True
    assert ros.wait_until(lambda: len(idle.plans) > before)
    assert stamps(idle)[before] >= hit - 1e-6


def test_hits_of_another_time_are_refused_and_change_nothing(ros, idle):
    before = len(idle.plans)
    for stamp in (0.0, 50.0, idle.robot.stamp + 2.0, idle.robot.stamp + 1e6):
        tell(idle, stamp)
    idle.wait_for_count("refused_impact", 4)
    assert "expected within 0.5 s" in idle.value("last_refusal")
    ros.spin(0.1)
    assert len(idle.plans) == before


def test_a_flood_of_hits_neither_starves_the_node_nor_makes_it_plan_without_end(ros):
    period = 0.1
    bench = rolling(ros, planner__map_period=period, limits__pose_age=0.5)
    bench.impacts = ros.publisher(Vector3Stamped, "impact", EVENT)
    bench.send_goal()
    bench.wait_for_plan()
    before, begun = len(bench.plans), time.monotonic()

    def publish():
        for _ in range(3):
            bench.impacts.publish(impact_to_message(bench.robot.stamp, CHANGE, "map"))

    flood = ros.probe.create_timer(0.01, publish)
    bench.wait_for_count("impacts", 100)
    made, lasted = len(bench.plans) - before, time.monotonic() - begun
    assert made <= (1 + 1 / ALARM_PERIODS) * lasted / period + 3
    assert int(bench.value("refused_impact")) > 50
    bench.robot.position = AHEAD - [0.0, 0.09]
    bench.wait_for(GoalStatus.STATUS_SUCCEEDED)
    ros.probe.destroy_timer(flood)


def test_false_hits_leave_the_plans_as_they_are(ros, idle):
    count = len(idle.plans)
    before = plan_from_path(idle.plans[-1], "map")
    tell(idle, idle.robot.stamp)
    assert ros.wait_until(lambda: len(idle.plans) > count)
    after = plan_from_path(idle.plans[-1], "map")
    assert after.stamp > before.stamp
    np.testing.assert_allclose(after.positions[0], before.positions[0], atol=1e-9)
    assert after.times[-1] - after.stamp == pytest.approx(before.times[-1] - before.stamp, abs=SCATTER)


def test_the_papers_strategies_do_not_wait_on_hits(ros):
    bench = PlannerBench(ros)
    bench.impacts = ros.publisher(Vector3Stamped, "impact", EVENT)
    wait_for_idleness(bench)
    before = len(bench.plans)
    tell(bench, bench.robot.stamp)
    ros.spin(0.2)
    assert len(bench.plans) == before


def test_costs_tell_the_terms_and_each_measured_rebound_once(ros, bench):
    bench.impacts = ros.publisher(Vector3Stamped, "impact", EVENT)
    bench.send_goal()
    bench.wait_for_plan()
    tell(bench, bench.robot.stamp)
    assert ros.wait_until(lambda: told_rebounds(bench))
    ros.spin(0.3)
    (rebound,) = told_rebounds(bench)
    assert float(rebound["rebound_measured_speed"]) == 0.0
    assert rebound["rebound_direction_error_deg"] == "nan"
    values = {v.key: v.value for v in bench.costs[-1].status[0].values}
    assert values["strategy"] == "bounce"
    assert int(values["foreseen_contacts"]) >= 0
    assert 0.5 < float(values["arrival_time"]) < 8.0
    assert 0 < int(values["candidates"]) <= 3125


def told_rebounds(bench):
    costs = [{v.key: v.value for v in message.status[0].values} for message in bench.costs]
    return [values for values in costs if "rebound_stamp" in values]


def closet():
    return parse_world({"name": "closet", "bounds": [-0.4, -0.4, 0.4, 0.4]}, "closet")


def test_goal_that_stays_closed_off_is_given_up_with_the_reason(ros, monkeypatch):
    monkeypatch.setattr(current_goal, "CLOSED_OFF_TIME", 0.3)
    bench = rolling(ros, closet())
    bench.send_goal()
    bench.wait_for(GoalStatus.STATUS_ABORTED)
    health = bench.health()
    assert health.level == DiagnosticStatus.WARN
    assert health.message == "goal given up: the goal 2.000, 0.000 is closed off by boundaries seen so far"
    assert int(bench.value("refused_no_plan")) >= 2
    assert not bench.plans


def test_goal_that_was_closed_off_for_a_moment_is_not_given_up(ros):
    bench = rolling(ros, closet())
    bench.send_goal()
    bench.wait_for_count("refused_no_plan")
    bench.robot.world = hall()
    # walls that vanish are believed when a person says so
    assert ros.wait_until(lambda: bench.node._loop.refusals["scan"] > 1)
    ros.publisher(Empty, "robot/resumed", EVENT).publish(Empty())
    bench.wait_for_plan()
    bench.wait_for(GoalStatus.STATUS_EXECUTING)
    assert bench.node._loop.goal._closed_since is None


@pytest.fixture
def budgets(monkeypatch):
    """The time that each plan may take [s]."""
    given = []
    monkeypatch.setattr(planner_node, "after", lambda budget, clock: given.append(budget) or never)
    return given


def test_a_plan_may_take_half_of_the_period(ros, bench, budgets):
    bench.send_goal()
    assert ros.wait_until(lambda: budgets)
    assert budgets[-1] == pytest.approx(BUDGET_SHARE * 0.05)
    bench.node.set_parameters([Parameter("planner.map_period", value=0.2)])
    assert ros.wait_until(lambda: budgets[-1] == pytest.approx(BUDGET_SHARE * 0.2))


def test_a_plan_may_take_the_time_budget_and_the_parameter_reads_as_it_was_set(ros, budgets):
    bench = rolling(ros, time_to_goal__time_budget=0.01)
    bench.send_goal()
    assert ros.wait_until(lambda: budgets)
    assert set(budgets) == {0.01}
    assert bench.node.get_parameter("time_to_goal.time_budget").value == 0.01


@pytest.mark.soak
def test_strategies_of_both_kinds_follow_each_other(ros, bench):
    bench.send_goal()
    bench.wait_for_plan()
    for strategy in ("harness", "stop_guarantee", "tolerate"):
        assert bench.node.set_parameters([Parameter("planner.strategy", value=strategy)])[0].successful
        assert ros.wait_until(lambda wanted=strategy: bench.value("strategy") == wanted)
        bench.wait_for_plan(bench.robot.stamp)
        assert bench.robot.stamp > 100.0
