"""The planner: from scans, poses and a goal to plans.

Every map_period it publishes a plan if it can make one: the paper planner from the newest scan and the pose at that
scan's stamp; the time-to-goal planner from the newest pose and all scans so far, and also at once when an impact is
reported. Without a plan it publishes nothing and reports the reason on /diagnostics; the controller stops the robot
when plans fail to come. A new goal replaces the old one. A goal is aborted if it is in another frame, not finite, or
inside an obstacle that the scan shows; if it is not reached within planner.goal_timeout, by the poses' clock; or if it
stays closed off by the boundaries seen. When the poses leap, fall silent or start over, memory is dropped and the goal
is given a new stamp, which refuses every earlier plan.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

from collplan_core.control.impact_alarm import ImpactAlarm, why_not_now
from collplan_core.control.permission import is_blocked, plan_age_limit, why_stale
from collplan_core.deadline import Deadline, after
from collplan_core.evaluation.rebound_tracking import MeasuredImpact, ReboundTracker
from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.parameters import (
    Frames,
    Limits,
    LocalMapping,
    Mocap,
    Planning,
    Rebound,
    Remembered,
    Robot,
    Settings,
    TimeToGoal,
    Weights,
)
from collplan_core.plan import NoPlan
from collplan_core.planners import map_period_of, planner_for
from collplan_core.scan import Scan, ScanError
from collplan_core.state import State
from collplan_core.warm_up import warm_up
from collplan_ros.messages import qos
from collplan_ros.messages.conversions import MessageError, goal_from_message, impact_from_message
from collplan_ros.node_kit.clock import local_clock, seconds
from collplan_ros.node_kit.diagnostics import ERROR, OK, WARN, Diagnostics, Health
from collplan_ros.node_kit.node_parameters import declare, on_change, read_settings
from collplan_ros.node_kit.refusals import Refusals
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.nodes.current_goal import CurrentGoal
from collplan_ros.nodes.plan_outputs import Cycle, PlanOutputs
from collplan_ros.nodes.sensor_buffer import REFUSED, RELOCATED, SensorBuffer

GROUPS = (Robot, Rebound, LocalMapping, Weights, Planning, Remembered, TimeToGoal, Mocap, Limits, Frames)
BUDGET_SHARE = 0.5
"""Time budget of refinement where time_to_goal.time_budget is 0, as a share of map_period: plans must not be late."""
ALARM_PERIODS = 2.0
"""Shortest time between two plans made at once after impacts, in map_periods."""


@dataclass(frozen=True, eq=False)
class PlacedScan:
    """The newest scan whose pose is known, the state at its stamp, and the local map made from both."""

    scan: Scan
    state: State
    local_map: LocalMap


class PlannerNode(Node):
    """Subscribes mocap/odom, scan, goal_pose, impact; publishes plan, goal_status and planner/*; serves cancel."""

    def __init__(self, **kwargs: Any) -> None:
        """Keyword arguments go to `rclpy.node.Node`."""
        super().__init__("planner_node", **kwargs)
        declare(self, *GROUPS)
        self._settings = read_settings(self, *GROUPS)
        self._planner = planner_for(self._settings.planner.strategy)
        self._local_clock = local_clock(self)
        self._refusals = Refusals()
        self._sensors = SensorBuffer(self._settings.limits.pose_history, self._refusals)
        self._alarm = ImpactAlarm()
        self._rebounds = ReboundTracker()
        self._impact: MeasuredImpact | None = None
        self._memory: Any = None
        self._placed: PlacedScan | None = None
        self._planned_until = 0.0
        self._trouble = ""
        self._n_plans = self._n_impacts = 0
        self._planning_time = 0.0
        warm_up()
        self._outputs = PlanOutputs(self)
        self._goal = CurrentGoal(self)
        self._make_inputs()
        on_change(self, self._take_settings, *GROUPS)
        self._diagnostics = Diagnostics(self, self._health)

    def _make_inputs(self) -> None:
        self.create_subscription(Odometry, "mocap/odom", self._on_pose, qos.POSE_SUBSCRIBED)
        self.create_subscription(LaserScan, "scan", self._on_scan, qos.SENSOR_DATA)
        self.create_subscription(PoseStamped, "goal_pose", self._on_goal, qos.EVENT)
        self.create_subscription(Vector3Stamped, "impact", self._on_impact, qos.EVENT)
        self.create_service(Trigger, "cancel", self._on_cancel)
        self._timer = self.create_timer(map_period_of(self._settings), self._cycle, clock=self._local_clock)

    def _take_settings(self, settings: Settings) -> None:
        if settings.planner.strategy != self._settings.planner.strategy:
            self._memory = None
            self._planner = planner_for(settings.planner.strategy)
        self._timer.timer_period_ns = round(map_period_of(settings) * 1e9)
        self._settings = settings

    # ---- inputs

    def _on_pose(self, message: Odometry) -> None:
        settings = self._settings
        taken, state = self._sensors.take_pose(message, seconds(self._local_clock), settings), self._sensors.state
        if taken == REFUSED or state is None:
            return
        if taken == RELOCATED:
            self._forget_before(state.stamp)
        if self._goal.is_reached(state, settings.planner.goal_tolerance):
            self._end_goal(GoalStatus.STATUS_SUCCEEDED)
        self._impact = self._rebounds.moved(state, settings.mocap.velocity_window) or self._impact
        self._plan_after_impact()

    def _forget_before(self, stamp: float) -> None:
        """Drops memory and plans from before a break in the poses at `stamp` [s]; an active goal is kept."""
        self._memory, self._placed, self._planned_until = None, None, stamp
        self._alarm.forget()
        self._rebounds.forget()
        self._trouble = ""
        self._goal.restamp(stamp)

    def _on_scan(self, message: LaserScan) -> None:
        self._sensors.take_scan(message, seconds(self._local_clock), self._settings)

    def _on_impact(self, message: Vector3Stamped) -> None:
        settings, local = self._settings, seconds(self._local_clock)
        try:
            stamp, change = impact_from_message(message, settings.frames.map)
        except MessageError as error:
            self._refusals.add("impact", str(error))
            return
        self._n_impacts += 1
        state = self._sensors.state
        reason = why_not_now(stamp, self._sensors.now(local), settings.limits.pose_age)
        if not reason and state is not None:
            self._rebounds.impact(stamp, change, state, settings.robot.radius)
            reason = self._alarm.raised(stamp, local, ALARM_PERIODS * map_period_of(settings))
        if reason:
            self._refusals.add("impact", reason)
            return
        self._plan_after_impact()

    def _plan_after_impact(self) -> None:
        if self._alarm.is_due(self._sensors.state) and self._planner.replans_after_impact:
            self._timer.reset()
            self._cycle()

    def _on_goal(self, message: PoseStamped) -> None:
        self._memory, self._planned_until, self._trouble = None, self._sensors.newest_stamp, ""
        try:
            position = goal_from_message(message, self._settings.frames.map)
        except MessageError as error:
            self._goal.refuse(self._planned_until)
            self._refuse_goal(str(error))
            return
        self._goal.accept(position, self._planned_until, self._sensors.now(seconds(self._local_clock)))

    def _on_cancel(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        response.message = "no goal was active"
        if self._goal.active:
            self._end_goal(GoalStatus.STATUS_CANCELED)
            response.message = "goal canceled"
        return response

    # ---- end of the goal

    def _end_goal(self, status: int) -> None:
        self._trouble = ""
        self._goal.set_status(status)

    def _give_up(self, reason: str) -> None:
        self._end_goal(GoalStatus.STATUS_ABORTED)
        self._trouble = f"goal given up: {reason}"
        self.get_logger().error(self._trouble)
        self._diagnostics.publish()

    def _refuse_goal(self, reason: str) -> None:
        self._trouble = f"goal refused: {reason}"
        self._refusals.add("goal", reason)
        self.get_logger().error(self._trouble)
        self._diagnostics.publish()

    # ---- planning

    def _cycle(self) -> None:
        if not self._goal.active:
            return
        local, timeout = seconds(self._local_clock), self._settings.planner.goal_timeout
        if self._goal.is_overdue(self._sensors.now(local), timeout):
            self._give_up(f"not reached within planner.goal_timeout, {timeout:g} s")
            return
        stale = self._why_stale(local)
        if stale:
            self._report_no_plan("stale", stale)
            return
        started = perf_counter()
        try:
            self._update_local_map()
        except ScanError as error:
            self._report_no_plan("no_plan", str(error))
            return
        initial, newest = self._initial_state(), self._sensors.scan_stamp or 0.0
        if initial is not None and initial.stamp > self._planned_until:
            self._plan(initial, started, local)
        elif initial is None or newest > self._planned_until:
            self._report_no_plan("no_pose", f"no pose for the scan's stamp {newest:.3f}")

    def _why_stale(self, local: float) -> str:
        limits = self._settings.limits
        return why_stale("pose", self._sensors.pose_age(local), limits.pose_age) or why_stale(
            "scan", self._sensors.scan_age(local), limits.scan_age
        )

    def _update_local_map(self) -> None:
        """Makes the local map of the newest scan whose pose is known, once per scan."""
        settings = self._settings
        placed = self._sensors.newest_placed(-math.inf if self._placed is None else self._placed.scan.stamp)
        if placed is not None:
            self._placed = PlacedScan(*placed, build_local_map(*placed, settings.robot, settings.local_map))

    def _initial_state(self) -> State | None:
        """Where a plan starts: at the newest pose or at that of the newest scan, as the planner has it."""
        placed, state, settings = self._placed, self._sensors.state, self._settings
        if placed is None or state is None or not self._planner.starts_at_newest_pose:
            return None if placed is None else placed.state
        # scans may still come in, but none with a known pose
        return state if state.stamp - placed.scan.stamp <= settings.limits.scan_age else None

    def _plan(self, initial: State, started: float, local: float) -> None:
        settings, placed, goal = self._settings, self._placed, self._goal
        assert placed is not None, "there is no initial state without it"
        if is_blocked(goal.position, placed.scan, placed.state, settings.robot, settings.local_map):
            self._end_goal(GoalStatus.STATUS_ABORTED)
            x, y = goal.position
            self._refuse_goal(f"{x:.3f}, {y:.3f} lies inside an obstacle that the scan shows")
            return
        try:
            plan, self._memory = self._planner.plan(
                self._memory, placed.local_map, initial, goal.position, settings, self._deadline(started)
            )
        except NoPlan as error:
            self._memory = error.memory or self._memory
            self._report_no_plan("no_plan", str(error))
            if self._planner.gives_up_closed_off_goal and goal.is_closed_off(local):
                self._give_up(str(error))
            return
        self._planning_time = perf_counter() - started
        boundaries = self._planner.boundaries(self._memory)
        valid_until = plan.stamp + plan_age_limit(map_period_of(settings))
        self._publish(Cycle(plan, valid_until, placed.local_map, boundaries, self._planning_time, self._impact), local)

    def _deadline(self, started: float) -> Deadline:
        """Until when a plan may be worked on: a plan must not be late."""
        settings = self._settings
        return after(started, settings.time_to_goal.time_budget or BUDGET_SHARE * map_period_of(settings))

    def _publish(self, cycle: Cycle, local: float) -> None:
        self._goal.mark_planned()
        self._outputs.publish(cycle, local, self._settings)
        self._rebounds.planned(cycle.plan)
        self._impact = None
        self._planned_until = cycle.plan.stamp
        self._trouble = ""
        self._n_plans += 1

    def _report_no_plan(self, kind: str, reason: str) -> None:
        self._trouble = reason
        self._refusals.add(kind, reason)
        self.get_logger().warning(f"no plan: {reason}", throttle_duration_sec=1.0)

    # ---- diagnostics

    def _health(self) -> Health:
        active = self._goal.active
        values: dict[str, object] = {
            "goal": self._goal.status_name,
            "strategy": self._settings.planner.strategy,
            "plans": self._n_plans,
            "planning_time_ms": 1e3 * self._planning_time,
            "impacts": self._n_impacts,
            **self._refusals.values,
        }
        stale = self._why_stale(seconds(self._local_clock))
        if stale:
            return Health(ERROR if active else WARN, stale, values)
        if self._trouble:
            return Health(WARN, self._trouble, values)
        return Health(OK, "planning" if active else "no active goal", values)

    def stop(self) -> None:
        """Cancels the goal and waits until listeners have received that."""
        self._goal.end()


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    return run_node(PlannerNode, args)
