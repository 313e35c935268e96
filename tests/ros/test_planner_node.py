"""What planner_node hears and publishes, with a fake robot that stands in a hall."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Empty
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from collplan_core.deadline import never
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.loop.sensed_scans import SensedScans
from collplan_core.movers.record import NO_MOVERS, Movers
from collplan_core.parameters import Settings
from collplan_core.planners import BUDGET_SHARE, deadlines
from collplan_ros.messages.cloud_reading import compared_from_message, plan_from_message, seen_from_message
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.planner_clouds import FREE_SPACE
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT, LATCHED
from collplan_ros.messages.raw_reading import plan_from_path
from collplan_ros.messages.reading import movers_from_markers, seconds_from_stamp
from collplan_ros.nodes.planner_node import PlannerNode
from collplan_ros.nodes.planner_outputs import PlannerOutputs
from fake_robot import FakeRobot, hall
from node_health import NodeHealth

AHEAD = np.array([2.0, 0.0])


def identity(status):
    return bytes(status.goal_info.goal_id.uuid)


class PlannerBench:
    def __init__(self, ros, world=None, **parameters):
        self.ros = ros
        self.plans = ros.listen(Path, "plan", EVENT)
        self.costs = ros.listen(DiagnosticArray, "planner/costs", EVENT)
        self.statuses = ros.listen(GoalStatus, "goal_status", DIAGNOSTICS_SUBSCRIBED)
        self.health = NodeHealth(ros, "/planner_node")
        self.robot = FakeRobot(ros, world or hall())
        overrides = {"planner.map_period": 0.05, **{k.replace("__", "."): v for k, v in parameters.items()}}
        self.node = ros.make(PlannerNode, overrides)
        self.goals = ros.publisher(PoseStamped, "goal_pose", EVENT)
        assert ros.wait_until(self.robot.is_heard)
        assert ros.wait_until(lambda: self.statuses)

    def send_goal(self, goal=AHEAD, frame="map"):
        known = {identity(status) for status in self.statuses}
        self.goals.publish(goal_to_message(goal, frame))
        assert self.ros.wait_until(lambda: [s for s in self.statuses if identity(s) not in known])
        return next(s for s in self.statuses if identity(s) not in known)

    def wait_for(self, status):
        assert self.ros.wait_until(lambda: self.statuses and self.statuses[-1].status == status)
        return self.statuses[-1]

    def wait_for_plan(self, after=0.0):
        assert self.ros.wait_until(lambda: self._plans_after(after)), self.health.newest
        return self._plans_after(after)[0]

    def _plans_after(self, stamp):
        # a message's stamp is rounded to nanoseconds
        return [p for p in self.plans if seconds_from_stamp(p.header.stamp) > stamp + 1e-6]

    def assert_no_more_plans(self):
        self.ros.spin(0.2)
        before = len(self.plans)
        self.ros.spin(0.25)
        assert len(self.plans) == before


@pytest.fixture
def bench(ros):
    return PlannerBench(ros)


def values_of(message) -> dict[str, str]:
    return {each.key: each.value for each in message.status[0].values}


def test_movers_are_published_once_a_scan_and_once_that_there_are_none(ros):
    node, heard = ros.make(partial(Node, "named")), ros.listen(MarkerArray, "movers", EVENT)
    sensed, settings = SensedScans(1.0), Settings()
    loop, outputs = PlannerLoop(settings, lambda _: never, sensed=sensed), PlannerOutputs(node)
    still_and_moving, two = np.array([[0.0, 0.0], [0.5, -0.3]]), np.ones(2)
    found = Movers(5.0, np.array([3, 7]), np.ones((2, 2)), still_and_moving, 0.1 * two, two, 5.0 * two)
    assert ros.wait_until(lambda: node.count_subscribers("/movers") == 1)
    for movers in (NO_MOVERS, found, found, replace(found, stamp=5.1), NO_MOVERS, NO_MOVERS):
        sensed.movers = movers
        outputs.take((), loop, 0.0, 0.0, settings)
    assert ros.wait_until(lambda: len(heard) == 3)
    ros.spin(0.1)
    (stamp, rows), (later, _), (end, none) = (movers_from_markers(message, "map") for message in heard)
    assert (stamp, later, end) == (5.0, 5.1, 5.1)
    np.testing.assert_allclose(rows, [[1.0, 1.0, 0.0, 0.0, 0.1], [1.0, 1.0, 0.5, -0.3, 0.1]])
    assert {marker.id for marker in heard[0].markers[1:]} == {3, 7}
    assert len(none) == 0


def test_a_goal_becomes_plans_with_what_belongs_to_them_until_the_robot_arrives(ros, bench):
    trajectories = ros.listen(PointCloud2, "planner/trajectory", EVENT)
    # whatever was active before it began
    assert [status.status for status in bench.statuses] == [GoalStatus.STATUS_UNKNOWN]
    accepted = bench.send_goal()
    assert accepted.status == GoalStatus.STATUS_ACCEPTED
    message = bench.wait_for_plan()
    plan = plan_from_path(serialize_message(message), "map")
    executing = bench.wait_for(GoalStatus.STATUS_EXECUTING)
    assert (identity(executing), executing.goal_info.stamp) == (identity(accepted), accepted.goal_info.stamp)
    assert 100.0 < seconds_from_stamp(accepted.goal_info.stamp) < plan.stamp <= bench.robot.stamp
    assert plan.times[0] == pytest.approx(plan.stamp, abs=2e-9)
    np.testing.assert_allclose(plan.positions[0], bench.robot.position, atol=1e-9)
    assert plan.positions[-1, 0] > 0.3
    assert ros.wait_until(lambda: bench.costs and trajectories)
    assert trajectories[0].header == message.header
    told = plan_from_message(trajectories[0], "map")
    np.testing.assert_allclose(told.times, plan.times, rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(told.positions, plan.positions)
    assert told.stamp < told.valid_until < told.stamp + 1.0
    assert bench.costs[0].header.stamp == message.header.stamp
    values = values_of(bench.costs[0])
    assert float(values["planning_time_ms"]) > 0.0
    assert 1 <= int(values["candidates"]) <= int(values["candidates_before_pruning"])
    terms = {"total", "position", "risk", "collision_risk", "gap_risk", "velocity"}
    assert all(math.isfinite(float(values[term])) for term in terms)
    # markers and clouds are made for whoever looks
    markers = ros.listen(MarkerArray, "planner/markers", LATCHED)
    seen, compared = (ros.listen(PointCloud2, f"planner/{name}", LATCHED) for name in ("seen", "compared"))
    assert ros.wait_until(lambda: markers and seen and compared)
    assert {"free_space", "frontiers", "candidates", "plan"} <= {marker.ns for marker in markers[0].markers}
    assert len(seen_from_message(seen[0], "map")[FREE_SPACE]) == Settings().local_map.n_rays
    assert len(compared_from_message(compared[0], "map").rows) > 0
    bench.robot.position = AHEAD - [0.0, 0.09]
    bench.wait_for(GoalStatus.STATUS_SUCCEEDED)
    bench.assert_no_more_plans()


def test_a_goal_is_replaced_refused_and_canceled(ros, bench):
    assert ros.call(Trigger, "cancel").success
    first = bench.send_goal()
    bench.wait_for_plan()
    second = bench.send_goal(np.array([0.0, 0.8]))
    assert identity(second) != identity(first)
    plan = plan_from_path(serialize_message(bench.wait_for_plan(seconds_from_stamp(second.goal_info.stamp))), "map")
    assert plan.positions[-1, 1] > 0.3
    for goal, frame, reason in (([math.nan, 0.0], "map", "finite"), (AHEAD, "odom", "'odom'")):
        assert bench.send_goal(np.array(goal), frame).status == GoalStatus.STATUS_ABORTED
        assert bench.health.says(reason, DiagnosticStatus.WARN)
    bench.assert_no_more_plans()
    bench.send_goal()
    bench.wait_for(GoalStatus.STATUS_EXECUTING)
    assert ros.call(Trigger, "cancel").success
    bench.wait_for(GoalStatus.STATUS_CANCELED)
    bench.assert_no_more_plans()
    bench.send_goal()
    bench.wait_for(GoalStatus.STATUS_EXECUTING)
    bench.node.stop()
    bench.wait_for(GoalStatus.STATUS_CANCELED)


def test_each_strategy_takes_over_from_any_other(ros):
    few = {"time_to_goal__proposals": 20, "time_to_goal__time_budget": 1.0}
    bench = PlannerBench(ros, planner__map_period=0.1, **few)
    bench.send_goal()

    def plans_by(strategy) -> int:
        return [values_of(each)["strategy"] for each in bench.costs].count(strategy)

    for strategy in ("harness", "bounce", "high_risk", "tolerate", "avoid", "low_risk", "stop_guarantee"):
        assert bench.node.set_parameters([Parameter("planner.strategy", value=strategy)])[0].successful
        assert ros.wait_until(lambda strategy=strategy: plans_by(strategy) > 1), strategy
    assert bench.statuses[-1].status == GoalStatus.STATUS_EXECUTING


def test_a_plan_may_take_a_share_of_the_period_or_the_time_budget_that_is_set():
    now = [100.0]
    until = deadlines(lambda: now[-1])
    for values, budget in (
        ({"planner.map_period": 0.2}, 0.2 * BUDGET_SHARE),
        ({"planner.map_period": 0.2, "time_to_goal.time_budget": 0.01}, 0.01),
    ):
        now.append(100.0)
        is_over = until(Settings().with_values(values))
        now.append(100.0 + 0.99 * budget)
        assert not is_over(), values
        now.append(100.0 + 1.01 * budget)
        assert is_over(), values


def test_the_planner_beats_while_its_executor_does_not_run(ros):
    beats = ros.listen(Empty, "planner/heartbeat", 100)
    planner = ros.make(PlannerNode)
    assert ros.wait_until(lambda: beats)
    ros.hold(planner)
    before = len(beats)
    assert ros.wait_until(lambda: len(beats) > before + 5)
