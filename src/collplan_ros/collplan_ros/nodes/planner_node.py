"""The planner: scans, poses, impacts and a goal in; plans and the status of the goal out.

It plans every map_period if it can, with some strategies also at once after an impact. Without a plan it publishes
nothing and reports why; the controller stops the robot when plans do not arrive. All decisions: collplan_core/loop.
"""

import uuid
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped, Vector3Stamped
from std_msgs.msg import Empty, String
from std_srvs.srv import Trigger

from collplan_core.deadline import never
from collplan_core.loop.decisions import ERROR, Cycle, Decision, Notice
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import (
    Frames,
    Limits,
    LocalMapping,
    MoverFinding,
    Planning,
    Rebound,
    Remembered,
    Robot,
    ScanInput,
    Settings,
    TimeToGoal,
    Weights,
)
from collplan_core.planners import deadlines, map_period_of
from collplan_core.replay.journal import PLANNER, Journal
from collplan_core.state import State
from collplan_core.warm_up import warm_up
from collplan_ros.messages import qos
from collplan_ros.messages.conversions import command_type
from collplan_ros.messages.reading import (
    MessageError,
    goal_from_message,
    impact_from_message,
    twist_of,
    velocity_from_twist,
)
from collplan_ros.messages.status_values import drive_from_message
from collplan_ros.node_kit.backlog import Backlog
from collplan_ros.node_kit.clock import call_each_period, follows_clock, keep_step
from collplan_ros.node_kit.diagnostics import Health
from collplan_ros.node_kit.graph_node import GraphNode
from collplan_ros.node_kit.inputs import EVENT, Inputs
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.nodes.goal_action import serve_goals
from collplan_ros.nodes.heartbeat import Heartbeat
from collplan_ros.nodes.planner_outputs import PlannerOutputs, health_of
from collplan_ros.nodes.sensor_inputs import listen_to_sensors

PLANNED = (Robot, Rebound, LocalMapping, Weights, Planning, TimeToGoal)
MOCAP = ("mocap.leap_margin", "mocap.velocity_window")
SINGLE = (*MOCAP, "controller.stamped_cmd_vel", "controller.rate")
GROUPS = (*PLANNED, Remembered, ScanInput, MoverFinding, Limits, Frames, *SINGLE)
LIVE = (*PLANNED, *MOCAP, "limits.pose_age", "limits.scan_age")

LEAD = 0.02
"""A plan is begun so long before the control period that is to follow it [s]: until then it is made and received."""


class PlannerNode(GraphNode):
    """Takes mocap/odom, scan, goal_pose, impact, commands; publishes plan, goal_status, movers, planner/*."""

    def __init__(self, **kwargs: Any) -> None:
        """Keyword arguments go to `rclpy.node.Node`."""
        super().__init__("planner_node", GROUPS, LIVE, **kwargs)
        self._constants.compare()
        publisher = self.create_publisher(String, "planner/journal", qos.JOURNAL)
        send = (lambda line: publisher.publish(String(data=line))) if self._settings.planner.journal else None
        journal = self._journal = Journal(PLANNER, send)
        journal.begin(self._settings)
        why_forbidden = journal.record_answers(lambda: self._constants.disagreement)
        # simulated time stands still while a plan is made
        deadline = journal.count_checks((lambda _: never) if follows_clock(self) else deadlines(perf_counter))
        loop = self._loop = PlannerLoop(self._settings, deadline, why_forbidden=why_forbidden)
        self._planning_time = 0.0
        warm_up()
        self._outputs = PlannerOutputs(self)
        backlog = Backlog(self)
        inputs = self._inputs = Inputs(self, loop.refusals, backlog)
        listen_to_sensors(inputs, journal, loop, self._on_pose, self._local, self._settings)
        listen, command = inputs.listen, command_type(self._settings.controller)
        listen(PoseStamped, "goal_pose", self._on_goal, qos.EVENT, EVENT, kind="goal")
        listen(Vector3Stamped, "impact", self._on_impact, qos.EVENT, EVENT)
        listen(Empty, "robot/resumed", lambda _: journal.call(loop.forget_scans), qos.EVENT, EVENT)
        listen(command, "cmd_vel", self._on_command, qos.NEWEST, EVENT)
        listen(DiagnosticStatus, "controller/drive", self._on_drive, qos.LATCHED, EVENT)
        listen(command, "hand/cmd_vel", lambda _: journal.call(loop.take_manual_command), qos.NEWEST, EVENT)
        self.create_service(Trigger, "cancel", self._on_cancel)
        self._tell = serve_goals(self, self._on_goal, lambda: self._decide(self._loop.cancel), backlog.holds)
        self._timer = call_each_period(self, map_period_of(self._settings.planner), self._on_timer, self._local_clock)
        self._begin(self._inputs)
        self._heartbeat = Heartbeat(self, backlog.tick)
        self._inputs.ready(self._about())

    def _about(self) -> str:
        return f"strategy {self._settings.planner.strategy}, a plan every {map_period_of(self._settings.planner):g} s"

    def _change(self, settings: Settings) -> None:
        self._journal.call(self._loop.change_settings, settings)
        self._timer.timer_period_ns = round(map_period_of(settings.planner) * 1e9)
        before, self._settings = self._about(), settings
        if self._about() != before:
            self.get_logger().info(self._about())

    # ---- inputs

    def _on_pose(self, state: State) -> None:
        if self._decide(self._loop.take_pose, state, self._local()):
            self._timer.reset()  # after an impact: the next plan is due a map_period later

    def _on_goal(self, message: PoseStamped, identity: bytes | None = None) -> None:
        identity = identity or uuid.uuid4().bytes
        try:
            position = goal_from_message(message, self._settings.frames.map)
        except MessageError as error:
            self._decide(self._loop.refuse_goal, identity, str(error))
        else:
            self._decide(self._loop.take_goal, identity, position, self._local())

    def _on_impact(self, message: Vector3Stamped) -> None:
        stamp, change = impact_from_message(message, self._settings.frames.map)
        if self._decide(self._loop.take_impact, stamp, change, self._local()):
            self._timer.reset()

    def _on_command(self, message: Twist | TwistStamped) -> None:
        velocity, _ = velocity_from_twist(twist_of(message))
        self._journal.call(self._loop.take_command, velocity, self._local())
        keep_step(self._timer, 1.0 / self._settings.controller.rate, LEAD)

    def _on_drive(self, message: DiagnosticStatus) -> None:
        self._journal.call(self._loop.take_drive, *drive_from_message(message))

    def _on_cancel(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        response.message = "goal canceled" if self._loop.goal.active else "no goal was active"
        self._decide(self._loop.cancel)
        return response

    def _on_timer(self) -> None:
        self._decide(self._loop.cycle, self._local())
        # last of all: the robot waits for the plan
        self._journal.end_cycle()

    # ---- decisions

    def _decide(self, decide: Callable[..., list[Decision]], *given: Any) -> bool:
        """Acts on the loop's decisions; returns whether one is a plan."""
        begun = perf_counter()
        decisions = self._journal.call(decide, *given)
        planned = any(isinstance(decision, Cycle) for decision in decisions)
        if planned:
            self._planning_time = perf_counter() - begun
        self._outputs.take(decisions, self._loop, self._planning_time, self._local(), self._settings)
        self._tell(decisions, self._loop, self._settings, self._local())
        if any(isinstance(decision, Notice) and decision.level == ERROR for decision in decisions):
            self._diagnostics.publish()
        return planned

    # ---- diagnostics

    def _health(self) -> Health:
        return health_of(self._loop, self._settings.planner.strategy, self._planning_time, self._local())

    def stop(self) -> None:
        """Cancels the goal and waits until subscribers have received that."""
        self._outputs.take_last(self._journal.call(self._loop.cancel))
        self._journal.end_cycle()

    def destroy_node(self) -> None:
        """Ends the heartbeat first."""
        self._heartbeat.end()
        super().destroy_node()


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    return run_node(PlannerNode, args)
