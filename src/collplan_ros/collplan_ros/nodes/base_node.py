"""Any base that takes velocities in its body frame as a robot on the graph: between cmd_vel and the topic of the base.

The base itself knows no hold, no emergency stop and no caps. They are this node's, and end with it and its machine:
docs/safety.md says what a laboratory must have in the place of a firmware.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry

from collplan_core.control.brush import Brush, judge_brush
from collplan_core.control.drive_record import DriveRecord
from collplan_core.control.motion_monitor import MotionRecord, add_command, add_pose
from collplan_core.control.runaway import why_runaway
from collplan_core.parameters import Base, Cap, Control, Frames, Limits, Robot, Settings
from collplan_core.parameters.spec import ParameterError
from collplan_ros.messages import qos
from collplan_ros.messages.conversions import header, twist_of
from collplan_ros.node_kit.clock import seconds, steady_clock
from collplan_ros.node_kit.diagnostics import Health
from collplan_ros.node_kit.graph_node import GraphNode
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.node_kit.publishers import Commanders
from collplan_ros.node_kit.run_node import publish_acknowledged, run_node
from collplan_ros.nodes.command_check import LIVE, check_caps
from collplan_ros.nodes.felt_impacts import FeltImpacts
from collplan_ros.nodes.robot_contract import RobotContract
from collplan_ros.nodes.touch_input import NONE, TouchInput

GROUPS = (Robot, Cap, Limits, Control, Frames, Base, "rebound.restitution")
NO_COMMAND = np.zeros(2), 0.0, -math.inf
"""Velocity [m/s], yaw rate [rad/s], and when it was sent [s], before the first command and after one has expired."""
FINAL_ZEROS = 3
"""Zero velocities sent at the end; a base that subscribes best effort may lose one."""


def check_base(settings: Settings) -> None:
    """Checks the caps, and that a base with a watchdog does not stop between two velocities; else ParameterError."""
    check_caps(settings)
    base = settings.base
    if 0.0 < base.watchdog * base.rate < 2.0:
        least = 2.0 / base.watchdog
        raise ParameterError(
            f"base.rate: got {base.rate:g}, expected at least {least:g} Hz: two velocities in base.watchdog"
        )


class BaseNode(GraphNode):
    """Sends the command on while it is fresh, else zero, at base.rate or more often."""

    def __init__(self, **kwargs: Any) -> None:
        """Keyword arguments go to `rclpy.node.Node`."""
        super().__init__("base_node", GROUPS, LIVE, check_base, **kwargs)
        base = self._settings.base
        self._topic = self.resolve_topic_name(base.topic)
        if self._topic == self.resolve_topic_name("cmd_vel"):
            raise ParameterError(
                f"base.topic: got {base.topic!r}, expected another topic than this node's own commands: "
                "start it and the other nodes in a namespace, as collplan"
            )
        # steady also where the graph follows /clock: the base does not
        self._steady = steady_clock()
        self._out = self.create_publisher(TwistStamped if base.stamped else Twist, self._topic, qos.NEWEST)
        self._others = Commanders(self, self._topic)
        self._command = NO_COMMAND
        self._sent_at = -math.inf
        self._stopped: tuple[float, float] | None = None
        self._speed = 0.0
        self._drive = DriveRecord()
        self._record, self._brush = MotionRecord(), Brush()  # what looks as if it ran away may be a brush
        self._told = ""
        self._counts = {"sent": 0, "expired": 0}
        self._inputs = Inputs(self)
        self.contract = RobotContract(self, self._inputs, self, self._settings)
        self._inputs.listen(Odometry, "mocap/odom", self._take_pose, qos.POSE_SUBSCRIBED, kind="pose", raw=True)
        self._felt = FeltImpacts(self, self._settings, self._steady)
        heard = self._inputs, self._felt, self._settings, self._steady
        self._touches = None if base.touch == NONE else TouchInput(*heard)
        self.create_timer(1.0 / base.rate, self._tick, clock=self._steady)
        self._begin(self._inputs)
        self._inputs.ready(f"{self._topic} at {base.rate:g} Hz")
        if not base.watchdog:
            self.get_logger().warning(
                "base.watchdog is 0: nothing stops the base when this node, its machine or the network fails"
            )

    def _change(self, settings: Settings) -> None:
        super()._change(settings)
        self.contract.change_settings(settings)

    # ---- interface for the contract

    def now(self) -> float:
        """The local time [s]."""
        return seconds(self._steady)

    def is_ready(self) -> bool:
        """Returns whether the base listens."""
        return bool(self._out.get_subscription_count() > 0)

    def follow(self, velocity: np.ndarray, yaw_rate: float, age: float) -> None:
        """Sends a velocity (2,) [m/s, robot frame] and a yaw rate [rad/s] at once, and again while they are fresh."""
        self._command = velocity, yaw_rate, self.now() - age
        self._send()

    def halt(self) -> None:
        """Sends zero at once."""
        self._send()

    def why_stay_stopped(self) -> str:
        """Nothing: the base keeps no emergency stop that this node could know of."""
        return ""

    def why_not_start(self) -> str:
        """Returns the reason why the robot must not begin to move; "" where it may."""
        self._others.look(self.now())
        if self._others.why_refused or self.is_ready():
            return self._others.why_refused
        other = "Twist" if self._settings.base.stamped else "TwistStamped"
        return f"no node subscribes to {self._topic}: is the driver of the base running, or does it take {other}?"

    # ---- what is sent

    def _tick(self) -> None:
        now = self.now()
        self._others.look(now)
        if self.contract.may_move and (reason := self._others.why_refused or self._why_lost()):
            self.contract.hold(reason)
        if now - self._sent_at > 0.5 / self._settings.base.rate:
            self._send()

    def _why_lost(self) -> str:
        return "" if self.is_ready() else f"no node subscribes to {self._topic} any more"

    def _send(self) -> None:
        now = self.now()
        velocity, yaw_rate, given = self._command
        if not self.contract.may_move:
            self._command = NO_COMMAND
        elif now - given < self._settings.limits.command_age:
            self._publish(velocity, yaw_rate)
            return
        elif math.isfinite(given):
            self._counts["expired"] += 1
            self._command = NO_COMMAND
        self._publish(np.zeros(2), 0.0)

    def _publish(self, velocity: np.ndarray, yaw_rate: float) -> None:
        self._sent_at = self.now()
        stands = not velocity.any() and not yaw_rate
        if not stands:
            self._stopped = None
        elif self._stopped is None:
            self._stopped = self._sent_at, self._speed
        if len(self._drive.motion):
            self._drive = self._drive.with_command(velocity, self._sent_at)
            self._record = add_command(self._record, self._drive)
        self._counts["sent"] += 1
        self._out.publish(self._message(velocity, yaw_rate))

    def _message(self, velocity: np.ndarray, yaw_rate: float) -> Twist | TwistStamped:
        twist = twist_of(velocity, yaw_rate)
        if not self._settings.base.stamped:
            return twist
        return TwistStamped(header=header(seconds(self.get_clock()), self._settings.frames.base), twist=twist)

    # ---- whether the base obeys

    def _take_pose(self, raw: bytes) -> None:
        now, state, told = self.now(), self._felt.take_pose(raw), self._brush.held
        self._speed = math.hypot(*state.velocity.tolist())
        self._drive = self._drive.with_pose(state, now)
        self._record = add_pose(self._record, self._drive, touching=False)
        # a base that is told to drive again need not come to rest
        put_off = "" if self._stopped is None else self._brush.why
        brush = replace(self._brush, why=put_off, held="")
        self._brush = judge_brush(brush, self._why_runaway(now), self._record, now, self._settings)
        why = self._brush.held
        if why and not told:
            # also while it is held or stopped: then nothing else says so
            self.get_logger().error(why)
            self.contract.hold(why)

    def _why_runaway(self, now: float) -> str:
        if self._stopped is None:
            return ""
        since, speed_then = self._stopped
        patience, robot = self._settings.base.runaway_time, self._settings.robot
        why = why_runaway(self._speed, speed_then, now - since, patience, robot)
        return f"the base {why}: does it take {self._topic}? Stop it by hand" if why else ""

    # ---- how it is

    def _health(self) -> Health:
        values = {**self.contract.counts, **self._counts, "speed_m_s": self._speed}
        if self._touches is not None:
            values |= {"impacts": self._touches.published, "impacts_missed": self._touches.missed}
        doubtful = "" if self._touches is None else self._touches.why_doubtful
        if doubtful and not self._told:
            self.get_logger().warning(doubtful)
        self._told = doubtful
        why = self._brush.held or self._why_lost() or doubtful
        return self.contract.health(values, why, f"sends to {self._topic}")

    def stop(self) -> None:
        """Sends zero and waits until the base has received it."""
        for _ in range(FINAL_ZEROS):
            publish_acknowledged(self._out, self._message(np.zeros(2), 0.0), timeout=0.1)


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable."""
    return run_node(BaseNode, args)
