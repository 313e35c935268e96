"""The robot's end of the contract on the graph: what each robot, simulated or real, does alike.

It takes cmd_vel and serves estop and clear_estop. Commands are ignored while the emergency stop is latched, and after
it until a zero command has come, or none for limits.command_age.
"""

from collections.abc import Callable
from typing import Protocol

import numpy as np
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node
from std_srvs.srv import Trigger

from collplan_core.control.arming import ARMED, WAITING, Arming
from collplan_core.parameters import Settings
from collplan_ros.messages.cmd_vel import command_type, twist_of
from collplan_ros.messages.conversions import asks_for_rest
from collplan_ros.messages.qos import NEWEST
from collplan_ros.node_kit.input_watch import AWAITED
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.nodes.command_check import REFUSED, CommandCheck


class Robot(Protocol):
    """What the contract needs of a robot."""

    def now(self) -> float:
        """The time in which the ages of commands are measured [s, any one clock]."""

    def is_ready(self) -> bool:
        """Whether commands can be followed at all."""

    def follow(self, velocity: np.ndarray, yaw_rate: float) -> None:
        """Follows a velocity (2,) [m/s, robot frame] and a yaw rate [rad/s] from now on."""

    def halt(self) -> None:
        """Stands still at once."""

    def why_stay_stopped(self) -> str:
        """Why the emergency stop cannot be cleared, empty where it can."""


class RobotContract:
    """Commands and the emergency stop of one robot.

    Attributes:
        stopped_by: what latched the emergency stop, in words; empty while it is not latched.
        ignored: commands ignored because of an emergency stop, or because the robot was not ready.
    """

    def __init__(self, node: Node, inputs: Inputs, robot: Robot, settings: Settings) -> None:
        """Subscribes through `inputs` and serves in `node`."""
        self.stopped_by = ""
        self.ignored = 0
        self._node = node
        self._robot = robot
        self._silence = settings.limits.command_age
        self._arming = ARMED
        self._check = CommandCheck(settings.robot, settings.limits)
        self._commands = 0
        inputs.listen(command_type(settings), "cmd_vel", self._take_command, NEWEST, AWAITED)
        self._serve("estop", self._stop)
        self._serve("clear_estop", self._clear_stop)

    def latch(self, by: str) -> None:
        """Latches the emergency stop; `by` says what did it: "by its service"."""
        if by != self.stopped_by:
            self.stopped_by = by
            self._node.get_logger().warning(f"emergency stop {by}: commands are ignored until clear_estop")

    @property
    def trouble(self) -> str:
        """Why the last command was not followed though no emergency stop is latched; empty where it was."""
        if self._is_waiting():
            return WAITING
        return REFUSED if self._check.last_refused else ""

    @property
    def counts(self) -> dict[str, int]:
        """Commands by what became of them, ready for a `Health`."""
        return {"commands": self._commands, "ignored": self.ignored, **self._check.counts}

    def _serve(self, name: str, act: Callable[[], tuple[bool, str]]) -> None:
        def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            response.success, response.message = act()
            return response

        self._node.create_service(Trigger, name, answer)

    def _take_command(self, message: Twist | TwistStamped) -> None:
        twist = twist_of(message)
        if self.stopped_by or self._is_waiting_after(twist) or not self._robot.is_ready():
            self.ignored += 1
            return
        self._commands += 1
        self._robot.follow(*self._check.followed(twist))

    def _is_waiting_after(self, twist: Twist) -> bool:
        self._arming = self._arming.after_command(asks_for_rest(twist), self._robot.now(), self._silence)
        return self._is_waiting()

    def _is_waiting(self) -> bool:
        return self._arming.is_waiting(self._robot.now(), self._silence)

    def _stop(self) -> tuple[bool, str]:
        self.latch("by its service")
        self._robot.halt()
        return True, "stopped; commands are ignored until clear_estop"

    def _clear_stop(self) -> tuple[bool, str]:
        reason = self._robot.why_stay_stopped()
        if reason:
            self._node.get_logger().warning(f"emergency stop not cleared: {reason}")
            return False, reason
        if self.stopped_by:
            self.stopped_by, self._arming = "", Arming(self._robot.now())
        self._node.get_logger().info("emergency stop cleared: commands are taken again after a zero command")
        return True, "commands are taken again after a zero command"
