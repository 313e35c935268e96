"""The controller: plans, poses, scans and manual commands in; a velocity command out, each period, without exception.

A person's command has priority over any plan. It follows any timed path, whichever node published it, while a goal is
active, and stands still with a reason otherwise. All decisions: collplan_core/loop.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Path
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Empty, String

from collplan_core.command import HAND, STOPPED, stopped
from collplan_core.control.permission import why_stale
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.parameters import Control, Frames, Limits, LocalMapping, MoverFinding, Robot, ScanInput, Settings
from collplan_core.plan import Plan
from collplan_core.replay.journal import CONTROLLER, Journal
from collplan_core.state import State
from collplan_core.warm_up import warm_up
from collplan_ros.messages import qos
from collplan_ros.messages.cloud_reading import plan_from_message
from collplan_ros.messages.raw_reading import plan_from_path
from collplan_ros.messages.reading import impact_from_message
from collplan_ros.messages.states import goal_from_status
from collplan_ros.messages.status_values import values_of
from collplan_ros.node_kit.backlog import Backlog
from collplan_ros.node_kit.clock import call_each_period
from collplan_ros.node_kit.diagnostics import WARN, Health
from collplan_ros.node_kit.graph_node import GraphNode
from collplan_ros.node_kit.inputs import EVENT, STATE, Inputs
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.nodes import heartbeat
from collplan_ros.nodes.controller_outputs import ControllerOutputs, ControlPeriod
from collplan_ros.nodes.sensor_inputs import listen_to_sensors
from collplan_ros.nodes.teleop_input import TeleopInput

MOCAP = ("mocap.leap_margin", "mocap.velocity_window")
NOISE = "mocap.position_noise"
GROUPS = (Robot, LocalMapping, Control, ScanInput, MoverFinding, Limits, Frames, "planner.journal", *MOCAP, NOISE)
MAPPED = "local_map.half_side"
"""The controller follows the boundaries of the local map alone; it does not read sight and set E."""
LIVE = (Robot, MAPPED, Control, Limits, *MOCAP)


class ControllerNode(GraphNode):
    """Takes mocap/*, scan, impact, plan, planner/*, goal_status, hand/cmd_vel; out: cmd_vel, maneuver, controller/*."""

    def __init__(self, **kwargs: Any) -> None:
        """Keyword arguments go to `rclpy.node.Node`."""
        super().__init__("controller_node", GROUPS, LIVE, **kwargs)
        self._constants.compare()
        publisher = self.create_publisher(String, "controller/journal", qos.JOURNAL)
        send = (lambda line: publisher.publish(String(data=line))) if self._settings.planner.journal else None
        self._journal = Journal(CONTROLLER, send)
        self._journal.begin(self._settings)
        self._loop = ControllerLoop(self._settings, self._journal.record_answers(self._why_forbidden))
        self._period = ControlPeriod()
        self._told: float | None = None
        warm_up()
        self._outputs = ControllerOutputs(self, self._settings)
        self._make_inputs()
        self._begin(self._inputs)
        self._inputs.ready(f"a command every {1e3 / self._settings.controller.rate:g} ms")

    def _make_inputs(self) -> None:
        listen = Inputs(self, self._loop.refusals, Backlog(self))
        self._inputs = listen
        listen.listen(Empty, heartbeat.TOPIC, lambda _: None, qos.NEWEST, EVENT)
        listen_to_sensors(listen, self._journal, self._loop, self._on_pose, self._local, self._settings)
        listen.listen(String, "mocap/refused", self._on_refused, qos.EVENT, EVENT, late_counts=True)
        listen.listen(Vector3Stamped, "impact", self._on_impact, qos.EVENT, EVENT)
        listen.listen(PointCloud2, "planner/trajectory", self._on_trajectory, qos.EVENT, EVENT)
        listen.listen(Path, "plan", self._on_path, qos.NEWEST, EVENT, raw=True)
        listen.listen(GoalStatus, "goal_status", self._on_status, qos.LATCHED, STATE)
        listen.listen(DiagnosticStatus, "robot/state", self._on_robot_state, qos.LATCHED, EVENT)
        listen.listen(Empty, "robot/resumed", self._on_resumed, qos.EVENT, EVENT)
        self._hand = TeleopInput(self, listen, self._settings, self._on_hand)
        call_each_period(self, 1.0 / self._settings.controller.rate, self._on_timer, self._local_clock)

    def _why_forbidden(self) -> str:
        age, limit = self._inputs.age(heartbeat.TOPIC), self._settings.limits.heartbeat_age
        # a planner that never had one is not missed
        silent = "" if math.isinf(age) else why_stale("planner heartbeat", age, limit)
        return self._constants.disagreement or silent

    def _change(self, settings: Settings) -> None:
        self._settings = settings
        self._journal.call(self._loop.change_settings, settings)

    # ---- inputs

    def _on_pose(self, state: State) -> None:
        self._journal.call(self._loop.take_pose, state, self._local())

    def _on_refused(self, message: String) -> None:
        self._journal.call(self._loop.refuse, "pose", message.data)

    def _on_impact(self, message: Vector3Stamped) -> None:
        self._journal.call(self._loop.take_impact, *impact_from_message(message, self._settings.frames.map))

    def _on_status(self, message: GoalStatus) -> None:
        self._journal.call(self._loop.take_goal, goal_from_status(message))

    def _on_robot_state(self, message: DiagnosticStatus) -> None:
        # a robot that stands by itself is commanded zero, so that it does not count as stuck
        # the reason alone: a controller that is held too reports how to release the robot
        reason = values_of(message).get("reason", message.message)
        self._journal.call(self._loop.take_robot_state, reason)

    def _on_resumed(self, _: Empty) -> None:
        self._journal.call(self._loop.resume)

    def _on_hand(self, velocity: np.ndarray, yaw_rate: float, age: float, trouble: str) -> None:
        self._journal.call(self._loop.take_manual_command, velocity, yaw_rate, self._local() - age, trouble)

    def _on_trajectory(self, message: PointCloud2) -> None:
        plan = plan_from_message(message, self._settings.frames.map)
        self._told = plan.stamp
        self._take_plan(plan)

    def _on_path(self, raw: bytes) -> None:
        plan = plan_from_path(raw, self._settings.frames.map)
        if plan.stamp != self._told:
            self._take_plan(plan)

    def _take_plan(self, plan: Plan) -> None:
        reason = self._journal.call(self._loop.take_plan, plan, self._local())
        # a goal's first plan may come before its status
        if reason and self._loop.goal_active:
            self._inputs.refused("plan", reason)

    # ---- control

    def _on_timer(self) -> None:
        local = self._local()
        self._period.tick(local)
        command = self._journal.call(self._loop.tick, local)
        self._outputs.send(command, self._loop, self._loop.now(local) or 0.0)
        # last of all: the robot waits for the command
        self._journal.end_cycle()

    # ---- diagnostics

    def _health(self) -> Health:
        values: dict[str, object] = {
            "maneuver": self._outputs.command.maneuver,
            "goal": self._loop.goal_status,
            "held": self._loop.held,
            "motion": self._loop.motion.verdict.kind,
            "motion_delay_s": self._loop.motion.verdict.delay,
            **self._period.values,
        }
        loop, maneuver, words = self._loop, self._outputs.command.maneuver, self._outputs.words(self._loop)
        is_to_move = loop.override_trouble or (
            maneuver == STOPPED and (loop.goal_active or self._constants.disagreement)
        )
        stands = words if is_to_move and maneuver in (HAND, STOPPED) else ""
        motion = "" if maneuver in (HAND, STOPPED) else loop.motion.verdict.reason
        return Health.of(values, words, (WARN, self._hand.why_refused()), (WARN, stands), (WARN, motion))

    def stop(self) -> None:
        """Commands zero and waits until the robot has received it."""
        self._outputs.send_last(stopped("the controller ends"), self._loop.now(self._local()) or 0.0)
        self._journal.end_cycle()


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    return run_node(ControllerNode, args)
