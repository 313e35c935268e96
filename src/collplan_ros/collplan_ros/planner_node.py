"""The planner: from scans, poses and a goal to plans.

Every map_period it takes the newest scan and the pose at that scan's stamp, and publishes a plan if it can make one.
If it cannot it publishes nothing and says why on /diagnostics; the controller stops the robot when plans fail to come.
A new goal replaces the old. A goal in another frame, not finite, or inside an obstacle that the scan shows is aborted.
A goal not reached within planner.goal_timeout, by the poses' clock, is aborted too.
When the poses leap, fall silent or start over, memory is dropped and the goal taken anew: its new stamp refuses every
earlier plan.
"""

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from nav_msgs.msg import Odometry, Path
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.objectives import NoPlan, objective_for
from collplan_core.params import Frames, Limits, LocalMapping, Planning, Rebound, Robot, Settings, Weights
from collplan_core.permission import is_blocked, why_stale
from collplan_core.plan import Plan
from collplan_core.scan import Scan, ScanError
from collplan_core.state import State
from collplan_core.strategies import map_period_of
from collplan_core.warm_up import warm_up
from collplan_ros import qos
from collplan_ros.clock import local_clock, seconds
from collplan_ros.conversions import (
    MessageError,
    contacts_to_path,
    goal_from_message,
    impact_from_message,
    plan_to_path,
    scan_from_message,
    state_from_odometry,
)
from collplan_ros.cost_report import costs_message
from collplan_ros.diagnostics import ERROR, OK, WARN, Diagnostics, Health
from collplan_ros.goal_status import Goal, goal_to_status
from collplan_ros.markers import plan_markers
from collplan_ros.node_parameters import declare, on_change, read_settings
from collplan_ros.refusals import Refusals
from collplan_ros.run_node import publish_acknowledged, run_node
from collplan_ros.sensed import Sensed

GROUPS = (Robot, Rebound, LocalMapping, Weights, Planning, Limits, Frames)


class PlannerNode(Node):
    """Subscribes mocap/odom, scan, goal_pose, impact; publishes plan, goal_status and planner/*; serves cancel."""

    def __init__(self, **kwargs: Any) -> None:
        """Keyword arguments go to `rclpy.node.Node`."""
        super().__init__("planner_node", **kwargs)
        declare(self, *GROUPS)
        self._settings = read_settings(self, *GROUPS)
        self._clock = local_clock(self)
        self._sensed = Sensed(self._settings.limits.pose_history)
        self._refusals = Refusals()
        self._goal: Goal | None = None
        self._goal_since: float | None = None
        self._memory: Any = None
        self._planned_until = 0.0
        self._trouble = ""
        self._n_plans = self._n_impacts = 0
        self._planning_time = 0.0
        warm_up()
        self._make_outputs()
        self._make_inputs()
        on_change(self, self._take_settings, *GROUPS)
        self._diagnostics = Diagnostics(self, self._health)

    def _make_outputs(self) -> None:
        self._plan_out = self.create_publisher(Path, "plan", qos.NEWEST)
        self._contacts_out = self.create_publisher(Path, "planner/foreseen_impacts", qos.NEWEST)
        self._markers_out = self.create_publisher(MarkerArray, "planner/markers", qos.LATCHED)
        self._costs_out = self.create_publisher(DiagnosticArray, "planner/costs", qos.EVENT)
        self._status_out = self.create_publisher(GoalStatus, "goal_status", qos.LATCHED)
        # of no goal: what a planner before this one left as active ends here
        self._status_out.publish(GoalStatus(status=GoalStatus.STATUS_UNKNOWN))

    def _make_inputs(self) -> None:
        self.create_subscription(Odometry, "mocap/odom", self._on_pose, qos.POSE_SUBSCRIBED)
        self.create_subscription(LaserScan, "scan", self._on_scan, qos.SENSOR_DATA)
        self.create_subscription(PoseStamped, "goal_pose", self._on_goal, qos.EVENT)
        self.create_subscription(Vector3Stamped, "impact", self._on_impact, qos.EVENT)
        self.create_service(Trigger, "cancel", self._on_cancel)
        self._timer = self.create_timer(map_period_of(self._settings), self._cycle, clock=self._clock)

    def _take_settings(self, settings: Settings) -> None:
        if settings.planner.strategy != self._settings.planner.strategy:
            self._memory = None
        self._timer.timer_period_ns = round(map_period_of(settings) * 1e9)
        self._settings = settings

    # ---- inputs

    def _on_pose(self, message: Odometry) -> None:
        settings = self._settings
        try:
            state = state_from_odometry(message, settings.frames.map, settings.frames.base)
        except MessageError as error:
            self._refusals.add("pose", str(error))
            return
        if self._sensed.add_pose(state, seconds(self._clock), settings.robot, settings.limits):
            self._begin_anew(state.stamp)
        goal = self._goal
        if goal is not None and goal.active and _distance(state, goal) <= settings.planner.goal_tolerance:
            self._set_status(GoalStatus.STATUS_SUCCEEDED)

    def _begin_anew(self, stamp: float) -> None:
        self._refusals.add("pose_break", f"the poses begin anew at {stamp:.3f}")
        self._memory, self._planned_until = None, stamp
        if self._goal is not None and self._goal.active:
            if self._goal_since is not None:  # the poses' clock may have been set back
                self._goal_since = min(self._goal_since, stamp)
            self._announce(replace(self._goal, stamp=stamp))

    def _on_scan(self, message: LaserScan) -> None:
        try:
            scan = scan_from_message(message, self._settings.frames.base)
        except ScanError as error:
            self._refusals.add("scan", str(error))
            return
        self._sensed.add_scan(scan, seconds(self._clock))

    def _on_impact(self, message: Vector3Stamped) -> None:
        try:
            impact_from_message(message, self._settings.frames.map)
        except MessageError as error:
            self._refusals.add("impact", str(error))
            return
        self._n_impacts += 1

    def _on_goal(self, message: PoseStamped) -> None:
        self._memory, self._planned_until = None, self._sensed.newest_stamp
        try:
            position = goal_from_message(message, self._settings.frames.map)
        except MessageError as error:
            self._announce(Goal(self._planned_until, np.full(2, np.nan), GoalStatus.STATUS_ABORTED))
            self._refuse_goal(str(error))
            return
        self._goal_since = self._sensed.now(seconds(self._clock))
        self._announce(Goal(self._planned_until, position))
        self.get_logger().info(f"goal {position[0]:.3f}, {position[1]:.3f} accepted")

    def _on_cancel(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        response.message = "no goal was active"
        if self._goal is not None and self._goal.active:
            self._set_status(GoalStatus.STATUS_CANCELED)
            response.message = "goal canceled"
        return response

    # ---- the goal's fate

    def _announce(self, goal: Goal) -> None:
        self._goal = goal
        self._trouble = ""
        self._status_out.publish(goal_to_status(goal))

    def _set_status(self, status: int) -> None:
        assert self._goal is not None
        self._announce(replace(self._goal, status=status))
        self.get_logger().info(f"goal {self._goal.status_name}")

    def _is_overdue(self, local: float) -> bool:
        now, timeout = self._sensed.now(local), self._settings.planner.goal_timeout
        if self._goal_since is None:  # no pose had come
            self._goal_since = now
        return bool(timeout) and now is not None and self._goal_since is not None and now - self._goal_since > timeout

    def _give_up(self) -> None:
        timeout = self._settings.planner.goal_timeout
        self._set_status(GoalStatus.STATUS_ABORTED)
        self._trouble = f"goal given up: not reached within planner.goal_timeout, {timeout:g} s"
        self.get_logger().error(self._trouble)

    def _refuse_goal(self, reason: str) -> None:
        self._trouble = f"goal refused: {reason}"
        self._refusals.add("goal", reason)
        self.get_logger().error(self._trouble)

    # ---- planning

    def _cycle(self) -> None:
        if self._goal is None or not self._goal.active:
            return
        local = seconds(self._clock)
        if self._is_overdue(local):
            self._give_up()
            return
        stale = self._why_stale(local)
        if stale:
            self._hold("stale", stale)
            return
        placed = self._sensed.newest_placed(self._planned_until)
        if placed is not None:
            self._plan(*placed)
        elif (self._sensed.scan_stamp or 0.0) > self._planned_until:
            self._hold("no_pose", f"no pose for the scan's stamp {self._sensed.scan_stamp:.3f}")

    def _why_stale(self, local: float) -> str:
        limits = self._settings.limits
        return why_stale("pose", self._sensed.pose_age(local), limits.pose_age) or why_stale(
            "scan", self._sensed.scan_age(local), limits.scan_age
        )

    def _plan(self, scan: Scan, state: State) -> None:
        settings, goal = self._settings, self._goal
        assert goal is not None
        if is_blocked(goal.position, scan, state, settings.robot, settings.local_map):
            self._set_status(GoalStatus.STATUS_ABORTED)
            self._refuse_goal(
                f"{goal.position[0]:.3f}, {goal.position[1]:.3f} lies inside an obstacle that the scan shows"
            )
            return
        begun = perf_counter()
        try:
            local_map = build_local_map(scan, state, settings.robot, settings.local_map)
            objective = objective_for(settings.planner.strategy)
            plan, self._memory = objective(self._memory, local_map, state, goal.position, settings)
        except (NoPlan, ScanError) as error:
            self._hold("no_plan", str(error))
            return
        self._planning_time = perf_counter() - begun
        self._publish(plan, local_map)

    def _publish(self, plan: Plan, local_map: LocalMap) -> None:
        settings, frame = self._settings, self._settings.frames.map
        if self._goal is not None and self._goal.status == GoalStatus.STATUS_ACCEPTED:
            self._set_status(GoalStatus.STATUS_EXECUTING)
        self._plan_out.publish(plan_to_path(plan, frame))
        self._contacts_out.publish(contacts_to_path(plan.contacts, plan.stamp, frame))
        name = self.get_fully_qualified_name()
        self._costs_out.publish(costs_message(name, plan, self._planning_time, settings.planner.strategy))
        if self._markers_out.get_subscription_count():
            self._markers_out.publish(plan_markers(local_map, plan, settings))
        self._planned_until = plan.stamp
        self._trouble = ""
        self._n_plans += 1

    def _hold(self, kind: str, reason: str) -> None:
        self._trouble = reason
        self._refusals.add(kind, reason)
        self.get_logger().warning(f"no plan: {reason}", throttle_duration_sec=1.0)

    # ---- how it is

    def _health(self) -> Health:
        goal = self._goal
        values: dict[str, object] = {
            "goal": "none" if goal is None else goal.status_name,
            "strategy": self._settings.planner.strategy,
            "plans": self._n_plans,
            "planning_time_ms": 1e3 * self._planning_time,
            "impacts": self._n_impacts,
            **self._refusals.values,
        }
        stale = self._why_stale(seconds(self._clock))
        if stale:
            return Health(ERROR if goal is not None and goal.active else WARN, stale, values)
        if self._trouble:
            return Health(WARN, self._trouble, values)
        return Health(OK, "planning" if goal is not None and goal.active else "no active goal", values)

    def stop(self) -> None:
        """Cancels the goal and waits until listeners know."""
        if self._goal is not None and self._goal.active:
            self._goal = replace(self._goal, status=GoalStatus.STATUS_CANCELED)
            publish_acknowledged(self._status_out, goal_to_status(self._goal))


def _distance(state: State, goal: Goal) -> float:
    return float(np.hypot(*(state.position - goal.position)))


def main(args: Sequence[str] | None = None) -> int:
    """Runs the node."""
    return run_node(PlannerNode, args)
