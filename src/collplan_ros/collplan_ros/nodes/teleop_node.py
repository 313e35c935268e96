"""A person's joystick: commands on hand/cmd_vel while the dead-man button is pressed, and buttons that stop and resume.

Each command is made from a message of the joystick; none is repeated. A release sends a zero at once, and then nothing.
So does a joystick that falls silent: its buttons count again once they were seen released for a while. Of two joysticks
none is followed, as it is unknown which of them is held.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from sensor_msgs.msg import Joy
from std_srvs.srv import Trigger

from collplan_core.ages import SenderAge
from collplan_core.command import HAND, Command, stopped
from collplan_core.control.joystick import DebouncedButton, JoyState, StickError, check_stick, velocity_of
from collplan_core.parameters import Frames, Teleop
from collplan_ros.messages.conversions import command_to_message, command_type
from collplan_ros.messages.qos import EVERY_UNRELIABLE, NEWEST
from collplan_ros.messages.reading import MessageError
from collplan_ros.node_kit.clock import seconds, steady_clock
from collplan_ros.node_kit.diagnostics import OK, WARN, Health
from collplan_ros.node_kit.graph_node import GraphNode
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.node_kit.run_node import publish_acknowledged, run_node
from collplan_ros.node_kit.service_calls import ServiceCalls
from collplan_ros.nodes.commanders import Commanders

GROUPS = (Teleop, Frames, "robot.max_speed", "robot.max_yaw_rate", "controller.stamped_cmd_vel")
SERVICES = ("estop", "resume")


class TeleopNode(GraphNode):
    """Subscribes joy; publishes hand/cmd_vel, and calls estop and resume."""

    def __init__(self, **kwargs: Any) -> None:
        """Keyword arguments go to `rclpy.node.Node`."""
        super().__init__("teleop_node", GROUPS, (), check_stick, **kwargs)
        teleop = self._settings.teleop
        # steady even where the node follows /clock: a person lets go in real time
        self._steady = steady_clock()
        self._age = SenderAge(teleop.joy_age)
        self._senders = Commanders(self, "joy")
        self._came = self._heard = -math.inf
        self._grip = self._resume = DebouncedButton()
        self._stop_pressed = False
        self._unsent: Command | None = None
        self._sent = 0
        self._hand = self.create_publisher(command_type(self._settings.controller), "hand/cmd_vel", NEWEST)
        self._calls = ServiceCalls(self)
        for name in SERVICES:
            self._calls.keep(Trigger, name)
        # messages queued while the node did not run show it by their age: a press of the stop button in them counts
        self._inputs = Inputs(self)
        self._inputs.listen(Joy, "joy", self._on_joy, EVERY_UNRELIABLE)
        self.create_timer(1.0 / teleop.rate, self._on_timer, clock=self._steady)
        self._begin()
        speed = teleop.speed_share * self._settings.robot.max_speed
        self._inputs.ready(f"dead-man button {teleop.dead_man_button}, {speed:.2f} m/s at full stick")

    # ---- the joystick

    def _on_joy(self, message: Joy) -> None:
        teleop, now = self._settings.teleop, seconds(self._steady)
        stick = JoyState(tuple(map(float, message.axes)), tuple(map(bool, message.buttons)))
        age = self._age.measured(self._inputs.sent, now)
        self._came = now
        self._senders.took(self._inputs.number, now)
        try:
            # a stop counts however late it arrives, and whichever node sends it
            self._on_stop(stick.pressed(teleop.stop_button))
            if self._senders.why_refused:
                raise StickError(self._senders.why_refused)
            if math.isinf(age):
                # another sender's first message, or one that queued up while this node did not run
                self._let_go()
                return
            if age > teleop.joy_age:
                remedy = "where a clock was set, restart joy_node"
                raise StickError(f"{age:.2f} s old, limit {teleop.joy_age:.2f} s; {remedy}")
            velocity, yaw_rate = velocity_of(stick, teleop, self._settings.robot)
            pressed, resume = stick.pressed(teleop.dead_man_button), stick.pressed(teleop.resume_button)
        except StickError as error:
            self._let_go()
            raise MessageError(str(error)) from None
        # its send time: transport does not prolong driving
        self._heard = now - age
        before, self._grip = self._grip, self._grip.after(pressed, now)
        if before.holds and not self._grip.holds:
            self._send(stopped("released"))
        self._on_resume(resume, pressed, now)
        if not self._grip.holds:
            return
        self._unsent = Command(velocity, yaw_rate, HAND, np.full(2, np.nan))
        if not before.holds:
            self._send(self._unsent)

    def _on_stop(self, pressed: bool) -> None:
        was_pressed, self._stop_pressed = self._stop_pressed, pressed
        if pressed and not was_pressed:
            # the controller stops at a manual command to stand, if no service answers
            self._grip = DebouncedButton()
            self._send(stopped("stop"))
            self._call("estop")

    def _on_resume(self, pressed: bool, dead_man_pressed: bool, now: float) -> None:
        before, self._resume = self._resume, self._resume.after(pressed, now)
        if before.holds or not self._resume.holds:
            return
        if dead_man_pressed:
            # whether it counts or not: a person who presses it means to have the robot, and the planner would drive
            self.get_logger().warning("resume: release the dead-man button first")
        else:
            self._call("resume")

    def _call(self, service: str) -> None:
        self._calls.now(service, Trigger.Request(), self._answered(service))

    def _answered(self, service: str) -> Callable[[Any, str], None]:
        def done(response: Any, trouble: str) -> None:
            said = trouble or response.message
            if trouble or not response.success:
                self.get_logger().error(f"{service}: {said}")
            else:
                self.get_logger().info(f"{service}: {said}")

        return done

    def _on_timer(self) -> None:
        self._calls.step()
        now = seconds(self._steady)
        self._senders.look(now)
        silence = now - self._heard
        if silence > self._settings.teleop.joy_age:
            if self._grip.holds:
                self.get_logger().warning(f"no joy message for {silence:.2f} s: release its dead-man button first")
            self._let_go()
        elif self._unsent is not None:
            self._send(self._unsent)

    def _let_go(self) -> None:
        """Stops a robot that is driven; buttons count again once they were seen released for a while."""
        was_held, self._grip, self._resume = self._grip.holds, DebouncedButton(), DebouncedButton()
        if was_held:
            self._send(stopped("let go"))

    def _send(self, command: Command) -> None:
        self._unsent = None
        self._sent += 1
        self._hand.publish(self._message(command))

    def _message(self, command: Command) -> Any:
        return command_to_message(command, seconds(self.get_clock()), self._settings)

    # ---- diagnostics

    def _health(self) -> Health:
        values: dict[str, object] = {"commands": self._sent, "holds": self._grip.holds, **self._inputs.refusals.values}
        now, joy_age = seconds(self._steady), self._settings.teleop.joy_age
        if now - self._heard > joy_age:
            refused = self._inputs.refusals.newest if now - self._came <= joy_age else ""
            return Health(WARN, f"joy refused: {refused}" if refused else "the joystick is silent", values)
        if not self._hand.get_subscription_count():
            return Health(WARN, "no node subscribes to hand/cmd_vel: start controller_node", values)
        if not self._grip.was_released:
            return Health(WARN, "waiting until the dead-man button is released", values)
        return Health(OK, "drives" if self._grip.holds else "dead-man button released", values)

    def stop(self) -> None:
        """Stops a driven robot, and waits until the controller has received that."""
        if self._grip.holds:
            publish_acknowledged(self._hand, self._message(stopped("teleop_node ends")))


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    return run_node(TeleopNode, args)
