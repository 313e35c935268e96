"""planner_node alone, with a fake robot that stands in a hall."""

import math

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import Vector3Stamped
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from collplan_core.worlds import parse_world
from collplan_ros.messages.conversions import impact_to_message, seconds_from_stamp
from collplan_ros.messages.plans import contacts_from_message, validity_from_message
from collplan_ros.messages.qos import CONSTANTS_PUBLISHED, EVENT, LATCHED
from collplan_ros.messages.reading import plan_from_path
from fake_robot import hall
from planner_bench import AHEAD, PlannerBench, identity

TO_THE_LEFT = np.array([0.0, 0.8])


@pytest.fixture
def bench(ros):
    return PlannerBench(ros)


def test_it_begins_without_a_goal_whatever_was_active_before(bench):
    assert [status.status for status in bench.statuses] == [GoalStatus.STATUS_UNKNOWN]


def test_goal_becomes_a_plan_of_a_later_scan(ros, bench):
    accepted = bench.send_goal()
    assert accepted.status == GoalStatus.STATUS_ACCEPTED
    plan = plan_from_path(bench.wait_for_plan(), "map")
    executing = bench.wait_for(GoalStatus.STATUS_EXECUTING)
    assert identity(executing) == identity(accepted)
    assert executing.goal_info.stamp == accepted.goal_info.stamp
    taken = seconds_from_stamp(accepted.goal_info.stamp)
    assert 100.0 < taken < plan.stamp <= bench.robot.stamp
    assert plan.times[0] == pytest.approx(plan.stamp, abs=2e-9)
    np.testing.assert_allclose(plan.positions[0], bench.robot.position, atol=1e-9)
    assert plan.positions[-1, 0] > 0.3


def test_costs_foreseen_impacts_and_validity_belong_to_the_plan(ros, bench):
    bench.send_goal()
    plan = bench.wait_for_plan()
    assert ros.wait_until(lambda: bench.costs and bench.contacts and bench.valid_until)
    assert bench.contacts[0].header == plan.header
    stamp, contacts = contacts_from_message(bench.contacts[0], "map")
    assert all(contacts.times >= stamp)
    assert bench.contacts[0].joint_names == ["base_link"]
    assert bench.valid_until[0].header.stamp == plan.header.stamp
    assert bench.valid_until[0].source == "/planner_node"
    made, until = validity_from_message(bench.valid_until[0])
    assert made < until < made + 1.0
    costs, stamp = bench.costs[0].status[0], bench.costs[0].header.stamp
    values = {v.key: v.value for v in costs.values}
    assert stamp == plan.header.stamp
    assert float(values["planning_time_ms"]) > 0.0
    assert 1 <= int(values["candidates"]) <= int(values["candidates_before_pruning"])
    assert values["strategy"] == "harness"
    terms = {"total", "position", "risk", "collision_risk", "gap_risk", "velocity"}
    assert all(math.isfinite(float(values[term])) for term in terms)


def test_markers_are_made_for_whoever_looks(ros, bench):
    bench.send_goal()
    bench.wait_for_plan()
    markers = ros.listen(MarkerArray, "planner/markers", LATCHED)
    assert ros.wait_until(lambda: markers)
    shown = {marker.ns for marker in markers[0].markers}
    assert {"free_space", "frontiers", "predicted", "candidates", "choice", "plan"} <= shown


def test_arrival_ends_the_plans(ros, bench):
    bench.send_goal()
    bench.wait_for_plan()
    bench.robot.position = AHEAD - [0.2, 0.0]
    bench.wait_for(GoalStatus.STATUS_EXECUTING)
    bench.robot.position = AHEAD - [0.15, 0.0]
    ros.spin(0.1)
    assert bench.statuses[-1].status == GoalStatus.STATUS_EXECUTING
    bench.robot.position = AHEAD - [0.0, 0.09]
    bench.wait_for(GoalStatus.STATUS_SUCCEEDED)
    bench.assert_no_more_plans()


def test_new_goal_replaces_the_old(ros, bench):
    first = bench.send_goal()
    bench.wait_for_plan()
    second = bench.send_goal(TO_THE_LEFT)
    assert second.status == GoalStatus.STATUS_ACCEPTED
    assert identity(second) != identity(first)
    taken = seconds_from_stamp(second.goal_info.stamp)
    assert taken > seconds_from_stamp(first.goal_info.stamp)
    plan = plan_from_path(bench.wait_for_plan(taken), "map")
    assert plan.positions[-1, 1] > 0.3
    assert bench.wait_for(GoalStatus.STATUS_EXECUTING)


def test_cancel_ends_the_plans(ros, bench):
    assert ros.call(Trigger, "cancel").message == "no goal was active"
    bench.send_goal()
    bench.wait_for_plan()
    answer = ros.call(Trigger, "cancel")
    assert (answer.success, answer.message) == (True, "goal canceled")
    bench.wait_for(GoalStatus.STATUS_CANCELED)
    bench.assert_no_more_plans()


def test_goal_not_reached_in_time_is_given_up(ros):
    bench = PlannerBench(ros, planner__goal_timeout=0.5)
    accepted = bench.send_goal()
    bench.wait_for_plan()
    begun = bench.robot.stamp
    aborted = bench.wait_for(GoalStatus.STATUS_ABORTED)
    assert identity(aborted) == identity(accepted)
    assert bench.robot.stamp - begun < 5.0
    # where the machine stalled, the pose is told as old first
    said = DiagnosticStatus.WARN, "goal given up: not reached within planner.goal_timeout, 0.5 s"
    assert ros.wait_until(lambda: (bench.health().level, bench.health().message) == said), bench.health()
    bench.assert_no_more_plans()
    again = bench.send_goal()
    assert again.status == GoalStatus.STATUS_ACCEPTED
    assert bench.wait_for_plan(seconds_from_stamp(again.goal_info.stamp))


def test_goal_is_given_up_although_poses_fail(ros):
    bench = PlannerBench(ros, planner__goal_timeout=0.5)
    bench.robot.poses_on = False
    bench.send_goal()
    bench.wait_for(GoalStatus.STATUS_ABORTED)


def test_time_for_a_goal_is_live_and_zero_is_never(ros):
    bench = PlannerBench(ros, planner__goal_timeout=0.0)
    bench.send_goal()
    ros.spin(0.6)
    assert bench.statuses[-1].status == GoalStatus.STATUS_EXECUTING
    bench.node.set_parameters([Parameter("planner.goal_timeout", value=0.5)])
    bench.wait_for(GoalStatus.STATUS_ABORTED)


BAD_GOALS = {
    "nan": (np.array([math.nan, 0.0]), "map", "expected finite"),
    "infinite": (np.array([1.0, math.inf]), "map", "expected finite"),
    "frame": (AHEAD, "odom", "'odom', expected 'map'"),
    "inside": (np.array([0.41, 0.0]), "map", "inside an obstacle"),
}


@pytest.mark.parametrize("kind", BAD_GOALS)
def test_bad_goal_is_aborted_and_ends_the_one_before(ros, kind):
    goal, frame, reason = BAD_GOALS[kind]
    bench = PlannerBench(ros, hall(obstacle_y=0.0))
    before = identity(bench.send_goal())
    bench.wait_for_plan()
    bench.send_goal(goal, frame)
    aborted = bench.wait_for(GoalStatus.STATUS_ABORTED)
    assert identity(aborted) != before
    bench.assert_no_more_plans()
    health = bench.wait_for_count("refused_goal")
    assert health.level == DiagnosticStatus.WARN
    assert reason in health.message


def test_bad_scans_are_counted_and_make_no_plan(ros, bench):
    bench.robot.scans_on = False
    bench.send_goal()
    bad = bench.robot.bad_scans()
    for scan in bad:
        bench.robot.scans.publish(scan)
        ros.spin(0.02)
    health = bench.wait_for_count("refused_scan", len(bad))
    assert "range" in {v.key: v.value for v in health.values}["last_refusal"]
    assert not bench.plans


@pytest.mark.parametrize("name", ["scan", "pose"])
def test_without_scans_or_poses_there_is_no_plan(ros, bench, name):
    bench.send_goal()
    bench.wait_for_plan()
    setattr(bench.robot, f"{name}s_on", False)
    # one may still have been under way, on a busy machine even after a stall that counts
    assert ros.wait_until(lambda: bench.health().level == DiagnosticStatus.ERROR)
    assert bench.health().message.startswith(f"{name} ")
    bench.wait_for_count("refused_stale")
    bench.assert_no_more_plans()


def test_scan_without_a_pose_for_its_stamp_makes_no_plan(ros, bench):
    bench.robot.scans_on = False
    bench.send_goal()
    early = bench.robot.scan()
    early.header.stamp.sec += 5
    bench.robot.scans.publish(early)
    assert ros.wait_until(lambda: bench.health().level != DiagnosticStatus.OK)
    assert int(bench.value("refused_scan")) == 1
    bench.assert_no_more_plans()


def test_bad_poses_are_counted(ros, bench):
    bench.robot.poses_on = False
    for pose in bench.robot.bad_poses():
        bench.robot.poses.publish(pose)
        ros.spin(0.02)
    bench.wait_for_count("refused_pose", 3)


def test_relocation_takes_the_goal_anew(ros, bench):
    taken = bench.send_goal()
    bench.wait_for_plan()
    bench.robot.position = np.array([0.5, -0.6])
    assert ros.wait_until(lambda: bench.statuses[-1].goal_info.stamp != taken.goal_info.stamp)
    again = bench.statuses[-1]
    assert identity(again) == identity(taken)
    plan = plan_from_path(bench.wait_for_plan(seconds_from_stamp(again.goal_info.stamp)), "map")
    np.testing.assert_allclose(plan.positions[0], [0.5, -0.6], atol=1e-9)
    between = [p for p in bench.plans if 0.0 < p.poses[0].pose.position.x < 0.49]
    assert not between


def test_plan_follows_an_obstacle_that_moves(ros):
    bench = PlannerBench(ros, hall(obstacle_y=0.1))
    bench.send_goal()
    right = plan_from_path(bench.wait_for_plan(), "map")
    bench.robot.world = hall(obstacle_y=-0.1)
    left = plan_from_path(bench.wait_for_plan(bench.robot.stamp), "map")
    assert right.positions[-1, 1] < 0.0 < left.positions[-1, 1]


def test_walled_in_there_is_no_plan(ros):
    closet = parse_world({"name": "closet", "bounds": [-0.4, -0.4, 0.4, 0.4]}, "closet")
    bench = PlannerBench(ros, closet)
    bench.send_goal()
    health = bench.wait_for_count("refused_no_plan")
    assert "no frontier" in health.message
    assert not bench.plans


def test_live_parameters_work_in_the_next_cycle_and_bad_ones_say_why(ros, bench):
    bench.send_goal()
    bench.wait_for_plan()
    good, period, bad, fixed = bench.node.set_parameters(
        [
            Parameter("planner.strategy", value="low_risk"),
            Parameter("planner.map_period", value=0.1),
            Parameter("planner.strategy", value="brave"),
            Parameter("robot.radius", value=0.2),
        ]
    )
    assert good.successful
    assert period.successful
    assert bench.node._timer.timer_period_ns == 100_000_000
    assert "'brave', expected one of harness" in bad.reason
    assert not fixed.successful
    last = bench.node._loop._planned_until
    assert ros.wait_until(lambda: [c for c in bench.costs if seconds_from_stamp(c.header.stamp) > last + 1e-6])
    assert KeyValue(key="strategy", value="low_risk") in bench.costs[-1].status[0].values


def test_where_constants_differ_it_makes_no_plan_and_names_the_key(ros, bench):
    others = ros.publisher(DiagnosticStatus, "shared_constants", CONSTANTS_PUBLISHED)
    values = [KeyValue(key="robot.radius", value="0.15")]
    others.publish(DiagnosticStatus(name="/driver_node", message="another hash", values=values))
    reason = "robot.radius: 0.09 here, 0.15 in /driver_node"
    assert ros.wait_until(lambda: bench.health().message == reason)
    bench.send_goal()
    bench.wait_for_count("refused_stale")
    assert bench.health().level == DiagnosticStatus.ERROR
    assert not bench.plans


def test_it_knows_no_world(bench):
    assert not [name for name in bench.node._parameters if "world" in name]


def test_impacts_are_counted(ros, bench):
    impacts = ros.publisher(Vector3Stamped, "impact", EVENT)
    impacts.publish(impact_to_message(100.0, np.array([0.5, 0.0]), "map"))
    impacts.publish(impact_to_message(100.0, np.array([0.5, 0.0]), "odom"))
    bench.wait_for_count("refused_impact")
    assert bench.value("impacts") == "1"


def test_stop_cancels_the_goal(ros, bench):
    bench.send_goal()
    bench.wait_for_plan()
    bench.node.stop()
    bench.wait_for(GoalStatus.STATUS_CANCELED)
