"""The real Omnipuck as a robot on the graph: takes cmd_vel, speaks to the firmware over a serial device."""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import Trigger

from collplan_core.control.arming import ARMED, WAITING, Arming
from collplan_core.parameters import Control, Driver, Frames, Kinematics, Limits, Robot
from collplan_ros.messages.conversions import asks_for_rest
from collplan_ros.messages.qos import NEWEST
from collplan_ros.node_kit.clock import seconds
from collplan_ros.node_kit.diagnostics import ERROR, OK, WARN, Diagnostics, Health
from collplan_ros.node_kit.node_parameters import declare, read_settings
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.nodes.command_check import REFUSED, CommandCheck
from omnipuck_driver.held_command import HeldCommand
from omnipuck_driver.kinematics import OmniWheels
from omnipuck_driver.link_report import LinkReport
from omnipuck_driver.messages import BATTERY_LOW, MOTOR_FAULT, SENSES_IMPACTS, TOO_HOT, Telemetry
from omnipuck_driver.sensed_impacts import SensedImpacts
from omnipuck_driver.serial_link import SerialLink
from omnipuck_driver.session import WheelCommand

GROUPS = (Robot, Limits, Control, Frames, Driver, Kinematics)
FAREWELLS = 3
"""Zero commands at the end; one might be lost."""
FAREWELL_PATIENCE = 0.2
"""For the last of them to leave [s]."""
FAULTS = {BATTERY_LOW: "the battery is low", MOTOR_FAULT: "a motor has failed", TOO_HOT: "too hot"}


class DriverNode(Node):
    """Sends a frame each period, whatever happens: the command while it is fresh, else zero."""

    def __init__(self, **kwargs: Any) -> None:
        """Keyword arguments go to `rclpy.node.Node`."""
        super().__init__("driver_node", **kwargs)
        declare(self, *GROUPS)
        self._settings = read_settings(self, *GROUPS)
        self._wheels = OmniWheels(self._settings.kinematics)
        # steady also where the graph follows /clock: the robot does not
        self._local_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._link = SerialLink(self._settings.driver, len(self._wheels))
        self._report = LinkReport(self._link)
        self._impacts: SensedImpacts | None = None
        self._command: HeldCommand | None = None
        self._estopped = ""
        self._arming = ARMED
        self._said = ""
        self._check = CommandCheck(self._settings.robot, self._settings.limits)
        self._counts = Counter({"commands": 0, "ignored": 0, "expired": 0})
        self._make_inputs(stamped=self._settings.controller.stamped_cmd_vel)
        self.create_timer(1.0 / self._settings.driver.rate, self._tick, clock=self._local_clock)
        self._diagnostics = Diagnostics(self, self._health)

    def _make_inputs(self, stamped: bool) -> None:
        if stamped:
            self.create_subscription(TwistStamped, "cmd_vel", lambda m: self._take_command(m.twist), NEWEST)
        else:
            self.create_subscription(Twist, "cmd_vel", self._take_command, NEWEST)
        self._serve("estop", self._stop_latched)
        self._serve("clear_estop", self._clear_stop)

    def _serve(self, name: str, act: Callable[[], tuple[bool, str]]) -> None:
        def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            response.success, response.message = act()
            return response

        self.create_service(Trigger, name, answer)

    # ---- commands

    def _take_command(self, twist: Twist) -> None:
        if self._estopped or self._waits_after(twist) or not self._link.armed:
            self._counts["ignored"] += 1
            return
        self._counts["commands"] += 1
        velocity, yaw_rate = self._check.followed(twist)
        wheels = self._wheels.saturated(self._wheels.speeds(velocity, yaw_rate))
        self._command = HeldCommand(tuple(wheels.tolist()), seconds(self._local_clock))

    def _waits_after(self, twist: Twist) -> bool:
        silence = self._settings.limits.command_age
        self._arming = self._arming.after_command(asks_for_rest(twist), seconds(self._local_clock), silence)
        return self._waits()

    def _waits(self) -> bool:
        return self._arming.is_waiting(seconds(self._local_clock), self._settings.limits.command_age)

    def _stop_latched(self) -> tuple[bool, str]:
        self._stop_for("by its service")
        return True, "stopped; commands are ignored until clear_estop"

    def _clear_stop(self) -> tuple[bool, str]:
        if self._link.session.button_pressed:
            return False, "the emergency stop on the robot is still pressed: release it first"
        if self._estopped:
            self._estopped, self._arming = "", Arming(seconds(self._local_clock))
        return True, "commands are taken again after a zero command"

    def _stop_for(self, reason: str) -> None:
        self._estopped = reason
        self._tick()

    # ---- the link

    def _tick(self) -> None:
        now = seconds(self._local_clock)
        for telemetry in self._link.receive(now):
            self._take_telemetry(telemetry)
        self._link.send(self._wheel_command(now), now)
        self._say_what_changed()

    def _wheel_command(self, now: float) -> WheelCommand:
        if self._estopped or not self._link.armed:
            # whatever comes afterwards must be told anew
            self._command = None
        if self._command is not None:
            wheel_command = self._command.wheel_command(now, self._settings.limits.command_age)
            if wheel_command is not None:
                return wheel_command
            self._counts["expired"] += 1
            self._command = None
        rest = (0.0,) * len(self._wheels)
        return WheelCommand(rest, 0.0, self._settings.limits.command_age, emergency_stop=bool(self._estopped))

    def _take_telemetry(self, telemetry: Telemetry) -> None:
        if self._link.session.button_pressed:
            self._estopped = "by the button on the robot"
        announced = self._link.session.announced
        if self._impacts is None and announced is not None and announced.capabilities & SENSES_IMPACTS:
            self._impacts = SensedImpacts(self, self._settings, self._local_clock)
        if self._impacts is not None:
            self._impacts.take(telemetry)

    def _say_what_changed(self) -> None:
        trouble = self._link.trouble()
        if trouble != self._said:
            self._said = trouble
            self.get_logger().info(trouble or "connected, the robot follows commands")
            self._diagnostics.publish()

    # ---- how it is

    def _health(self) -> Health:
        values = {**self._counts, **self._check.counts, **self._report.values()}
        if self._impacts is not None:
            values |= {"impacts": self._impacts.published, "impacts_missed": self._impacts.missed}
        if self._estopped:
            return Health(WARN, f"emergency stop {self._estopped}: commands are ignored", values)
        if self._link.trouble():
            return Health(ERROR, self._link.trouble(), values)
        if self._waits():
            return Health(WARN, WAITING, values)
        if self._check.last_refused:
            return Health(WARN, REFUSED, values)
        telemetry = self._link.session.telemetry
        faults = [words for bit, words in FAULTS.items() if telemetry is not None and telemetry.status & bit]
        return Health(WARN, ", ".join(faults), values) if faults else Health(OK, "connected", values)

    def stop(self) -> None:
        """Sends zero and waits until it has left."""
        self._command = None
        for _ in range(FAREWELLS):
            now = seconds(self._local_clock)
            self._link.send(self._wheel_command(now), now)
        deadline = time.monotonic() + FAREWELL_PATIENCE
        while not self._link.drained() and time.monotonic() < deadline:
            time.sleep(0.005)

    def destroy_node(self) -> None:
        """Gives the device back."""
        self._link.close()
        super().destroy_node()


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable."""
    return run_node(DriverNode, args)
