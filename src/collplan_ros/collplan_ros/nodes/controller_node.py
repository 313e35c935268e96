"""The controller: turns plans and poses into velocity commands, one each period, without exception.

It commands zero unless a goal is active and pose, scan and plan are fresh, and reports the reason. A spline is followed
with the local map of the scan it was planned from; a rollout without a map, once the pose it starts at has come.
`controller/reference` (PointStamped, map frame) is the point tracked at present, published at the controller's rate
while it moves the robot: ref_x, ref_y of a recorded run.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, PointStamped
from nav_msgs.msg import Odometry, Path
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

from collplan_core.command import Command, stopped
from collplan_core.control.memory import ControllerMemory
from collplan_core.control.permission import stop_reason, why_refuse_plan
from collplan_core.control.tracking import clip_command
from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.parameters import Control, Frames, Limits, LocalMapping, Planning, Rebound, Robot, Settings
from collplan_core.plan import Plan
from collplan_core.planners import FollowFunction, map_period_of, planner_for
from collplan_core.warm_up import warm_up
from collplan_ros.messages import qos
from collplan_ros.messages.cmd_vel import command_to_message, command_type
from collplan_ros.messages.conversions import header
from collplan_ros.messages.plans import PathError, plan_from_path
from collplan_ros.node_kit.clock import local_clock, seconds
from collplan_ros.node_kit.diagnostics import OK, WARN, Diagnostics, Health
from collplan_ros.node_kit.node_parameters import declare, on_change, read_settings
from collplan_ros.node_kit.refusals import Refusals
from collplan_ros.node_kit.run_node import publish_acknowledged, run_node
from collplan_ros.nodes.control_period import ControlPeriod
from collplan_ros.nodes.goal_status import StampedGoal, goal_from_status
from collplan_ros.nodes.sensor_buffer import RELOCATED, SensorBuffer

GROUPS = (Robot, Rebound, LocalMapping, Control, Planning, Limits, Frames, "mocap.leap_margin")


@dataclass(frozen=True, eq=False)
class FollowedPlan:
    """The plan being followed.

    Attributes:
        plan: the plan.
        received: time of receipt [s, local clock].
        follow: control law of the strategy that made the plan.
        local_map: local map of the scan that the plan was made from; None where the control law needs none.
    """

    plan: Plan
    received: float
    follow: FollowFunction
    local_map: LocalMap | None


class ControllerNode(Node):
    """Subscribes mocap/odom, scan, plan, goal_status; publishes cmd_vel, maneuver and controller/reference."""

    def __init__(self, **kwargs: Any) -> None:
        """Keyword arguments go to `rclpy.node.Node`."""
        super().__init__("controller_node", **kwargs)
        declare(self, *GROUPS)
        self._settings = read_settings(self, *GROUPS)
        self._local_clock = local_clock(self)
        self._refusals = Refusals()
        self._sensors = SensorBuffer(self._settings.limits.pose_history, self._refusals)
        self._period = ControlPeriod()
        self._goal: StampedGoal | None = None
        self._waiting: tuple[Plan, float] | None = None
        self._followed: FollowedPlan | None = None
        self._memory = ControllerMemory()
        self._command = stopped("just started")
        warm_up()
        self._make_outputs()
        self._make_inputs()
        on_change(self, self._take_settings, *GROUPS)
        self._diagnostics = Diagnostics(self, self._health)

    def _make_outputs(self) -> None:
        self._command_out = self.create_publisher(command_type(self._settings), "cmd_vel", qos.NEWEST)
        self._maneuver_out = self.create_publisher(String, "maneuver", qos.LATCHED)
        self._reference_out = self.create_publisher(PointStamped, "controller/reference", qos.EVENT)
        self._maneuver_out.publish(String(data=self._command.maneuver))

    def _make_inputs(self) -> None:
        self.create_subscription(Odometry, "mocap/odom", self._on_pose, qos.POSE_SUBSCRIBED)
        self.create_subscription(LaserScan, "scan", self._on_scan, qos.SENSOR_DATA)
        self.create_subscription(Path, "plan", self._on_plan, qos.NEWEST)
        self.create_subscription(GoalStatus, "goal_status", self._on_status, qos.LATCHED)
        self.create_timer(1.0 / self._settings.controller.rate, self._tick, clock=self._local_clock)

    def _take_settings(self, settings: Settings) -> None:
        self._settings = settings

    # ---- inputs

    def _on_pose(self, message: Odometry) -> None:
        if self._sensors.take_pose(message, seconds(self._local_clock), self._settings) == RELOCATED:
            self._forget_plans()

    def _on_scan(self, message: LaserScan) -> None:
        if self._sensors.take_scan(message, seconds(self._local_clock), self._settings):
            self._adopt()

    def _on_status(self, message: GoalStatus) -> None:
        goal = goal_from_status(message)
        if self._goal is None or self._goal.id != goal.id:
            self._memory = ControllerMemory()
        self._goal = goal
        if not goal.active or any(plan.stamp <= goal.stamp for plan in self._plans()):
            self._forget_plans()

    def _plans(self) -> list[Plan]:
        waiting = [] if self._waiting is None else [self._waiting[0]]
        return waiting if self._followed is None else [*waiting, self._followed.plan]

    def _on_plan(self, message: Path) -> None:
        local = seconds(self._local_clock)
        try:
            plan = plan_from_path(message, self._settings.frames.map)
        except PathError as error:
            self._refuse_plan(str(error))
            return
        goal_stamp = self._goal.stamp if self._goal is not None and self._goal.active else None
        reason = why_refuse_plan(plan, goal_stamp, self._sensors.now(local))
        if reason:
            self._refuse_plan(reason)
            return
        if self._waiting is not None:
            self._refuse_plan(f"its scan of {self._waiting[0].stamp:.3f} never came, or no pose for it")
        self._waiting = plan, local
        self._adopt()

    def _refuse_plan(self, reason: str) -> None:
        self._refusals.add("plan", reason)
        self.get_logger().warning(f"plan refused: {reason}", throttle_duration_sec=1.0)

    def _adopt(self) -> None:
        """Starts to follow the waiting plan once its scan and pose have come: topics have no common order."""
        if self._waiting is None:
            return
        plan, received = self._waiting
        planner = planner_for(self._settings.planner.strategy)
        if not planner.follows_by_map:
            # no pose is kept for a plan made before a break in the poses
            if self._sensors.pose_at(plan.stamp) is not None:
                self._waiting, self._followed = None, FollowedPlan(plan, received, planner.follow, None)
            return
        placed = self._sensors.placed_at(plan.stamp)
        if placed is not None:
            self._waiting = None
            local_map = build_local_map(*placed, self._settings.robot, self._settings.local_map)
            self._followed = FollowedPlan(plan, received, planner.follow, local_map)

    def _forget_plans(self) -> None:
        self._waiting = self._followed = None
        self._memory = ControllerMemory()

    # ---- control

    def _tick(self) -> None:
        local = seconds(self._local_clock)
        self._period.tick(local)
        self._send(self._decide(local), self._sensors.now(local) or 0.0)

    def _decide(self, local: float) -> Command:
        self._adopt()
        reason = self._stop_reason(local)
        followed, state, now = self._followed, self._sensors.state, self._sensors.now(local)
        if reason or followed is None or state is None or now is None:
            self._memory = ControllerMemory(heading=self._memory.heading)
            return stopped(reason)
        settings = self._settings
        command, self._memory = followed.follow(self._memory, followed.plan, followed.local_map, state, now, settings)
        clipped = clip_command(command.velocity, command.yaw_rate, settings.robot, settings.limits)
        if clipped is None:
            self._refusals.add("command", f"{command.velocity.tolist()} m/s, {command.yaw_rate} rad/s")
            return stopped("the command is not finite or far beyond the limits")
        return replace(command, velocity=clipped[0], yaw_rate=clipped[1])

    def _stop_reason(self, local: float) -> str:
        return stop_reason(
            goal_active=self._goal is not None and self._goal.active,
            pose_age=self._sensors.pose_age(local),
            scan_age=self._sensors.scan_age(local),
            plan_age=float("inf") if self._followed is None else local - self._followed.received,
            map_period=map_period_of(self._settings),
            limits=self._settings.limits,
        )

    def _send(self, command: Command, now: float) -> None:
        self._command_out.publish(command_to_message(command, now, self._settings))
        if not command.reason:
            x, y = command.reference.tolist()
            head = header(now, self._settings.frames.map)
            self._reference_out.publish(PointStamped(header=head, point=Point(x=x, y=y, z=0.0)))
        if command.maneuver != self._command.maneuver:
            self._maneuver_out.publish(String(data=command.maneuver))
            self.get_logger().info(f"{command.maneuver} {command.reason}".rstrip())
        self._command = command

    # ---- diagnostics

    def _health(self) -> Health:
        active = self._goal is not None and self._goal.active
        values: dict[str, object] = {
            "maneuver": self._command.maneuver,
            "goal": "none" if self._goal is None else self._goal.status_name,
            **self._period.values,
            **self._refusals.values,
        }
        if not self._command.reason:
            return Health(OK, "moving", values)
        return Health(WARN if active else OK, f"standing still: {self._command.reason}", values)

    def stop(self) -> None:
        """Commands zero and waits until the robot has received it."""
        command = stopped("the controller ends")
        if self._command.maneuver != command.maneuver:
            self._maneuver_out.publish(String(data=command.maneuver))
        now = self._sensors.now(seconds(self._local_clock)) or 0.0
        publish_acknowledged(self._command_out, command_to_message(command, now, self._settings))


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    return run_node(ControllerNode, args)
