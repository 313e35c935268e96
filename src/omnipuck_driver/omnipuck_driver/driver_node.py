"""The real Omnipuck as a robot on the graph: takes cmd_vel, and communicates with the firmware over a serial device."""

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from collplan_core.parameters import Cap, Control, Driver, Frames, Kinematics, Limits, Robot, Settings
from collplan_ros.node_kit.clock import seconds, steady_clock
from collplan_ros.node_kit.diagnostics import ERROR, Health
from collplan_ros.node_kit.graph_node import GraphNode
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.node_kit.run_node import run_node
from collplan_ros.nodes.command_check import LIVE, check_caps
from collplan_ros.nodes.robot_contract import RobotContract
from omnipuck_driver.kinematics import OmniWheels, check_command_rate
from omnipuck_driver.link_report import LinkReport
from omnipuck_driver.messages import (
    ARMED,
    BATTERY_LOW,
    ESTOP_LATCHED,
    ESTOP_PRESSED,
    EXPIRED,
    MOTOR_FAULT,
    SENSES_IMPACTS,
    STALLED,
    TOO_HOT,
    Telemetry,
)
from omnipuck_driver.sensed_impacts import SensedImpacts
from omnipuck_driver.serial_link import SerialLink
from omnipuck_driver.session import TOO_LATE, HeldCommand, Permission, WheelCommand

GROUPS = (Robot, Cap, Limits, Control, Frames, Driver, Kinematics)
FINAL_ZEROS = 3
"""Zero commands sent at the end; one might be lost."""
FINAL_WAIT = 0.2
"""Longest wait for the last zero command to leave the device [s]."""
LOG_PERIOD = 1.0
"""Shortest time between two lines about the link: on a bad one they would come without end [s]."""
UNARMED = 25
"""Periods in a row, half a second, with telemetry of a firmware that does not arm, or does not receive its release."""
BATTERY = {BATTERY_LOW: "the battery is low: the next goal is refused until it is charged"}
"""A robot that moves goes on to its goal."""
FAULTS = {MOTOR_FAULT: "a motor has failed", TOO_HOT: "too hot"}
"""The robot stands still at once, and is held."""
LOGGED = {
    **BATTERY,
    **FAULTS,
    STALLED: "the firmware was held up",
    EXPIRED: "stopped by the firmware: the last command outlived its life",
}
"""Log lines for faults when they begin, by their bit in the telemetry's status."""


class DriverNode(GraphNode):
    """Sends a frame each period, whatever happens: the command while it is fresh, else zero."""

    def __init__(self, **kwargs: Any) -> None:
        """Keyword arguments go to `rclpy.node.Node`."""
        super().__init__("driver_node", GROUPS, LIVE, check_caps, **kwargs)
        self._wheels = OmniWheels(self._settings.kinematics)
        check_command_rate(self._settings.driver, self._settings.limits, len(self._wheels))
        # steady also where the graph follows /clock: the robot does not
        self._local_clock = steady_clock()
        caps = self._wheels.caps(self._settings.cap, self._settings.robot)
        self.link = SerialLink(self._settings.driver, len(self._wheels), caps)
        self._report = LinkReport(self.link)
        self._impacts: SensedImpacts | None = None
        self._command: HeldCommand | None = None
        self._expired = 0
        self._session: int | None = None
        self._was_armed = False
        self._unarmed = 0
        self._logged_trouble: str | None = None
        self._logged_at = float("-inf")
        self._status = 0
        self._warned_at: dict[int, float] = {}
        self._inputs = Inputs(self)
        self.contract = RobotContract(self, self._inputs, self, self._settings)
        driver = self._settings.driver
        self.create_timer(1.0 / driver.rate, self._tick, clock=self._local_clock)
        self._begin(self._inputs)
        self._inputs.ready(f"{driver.port} at {driver.baud} bit/s, {len(self._wheels)} wheels")
        self._logged_at = self.now()

    def _change(self, settings: Settings) -> None:
        self.contract.change_settings(settings)

    # ---- interface for the contract

    def now(self) -> float:
        """The local time [s]."""
        return seconds(self._local_clock)

    def is_ready(self) -> bool:
        """Returns whether the firmware follows commands."""
        return self.link.armed

    def follow(self, velocity: np.ndarray, yaw_rate: float, age: float) -> None:
        """Holds the wheel speeds for a velocity (2,) [m/s, robot frame] and a yaw rate [rad/s] for the next frames."""
        wheels = self._wheels.saturated(self._wheels.speeds(velocity, yaw_rate))
        self._command = HeldCommand(tuple(wheels.tolist()), self.now() - age)

    def halt(self) -> None:
        """Sends at once that the robot may not move."""
        self._tick()

    def why_stay_stopped(self) -> str:
        """Returns the reason why the emergency stop cannot be cleared; "" where it can."""
        if self.link.session.button_pressed:
            return "the emergency stop on the robot is still pressed: release it first"
        trouble = self.link.trouble()
        return f"the firmware, which keeps it, cannot be reached: {trouble}" if trouble else ""

    def why_not_start(self) -> str:
        """Returns the reason why the robot must not begin to move; "" where it may."""
        return self.link.trouble() or self._faults(FAULTS | BATTERY)

    # ---- the link

    def _tick(self) -> None:
        now = self.now()
        news = self.link.receive(now)
        # once for all bytes received while this node was held up: it has sent nothing meanwhile
        self._unarmed = self._unarmed + bool(news) if self._waits else 0
        for telemetry in news:
            self._take_telemetry(telemetry)
        self._hold_where_the_link_was_lost()
        self._send(now)
        self._report_changes(now)

    def _send(self, now: float) -> None:
        self.link.send(self._wheel_command(now), self._permission, now)

    @property
    def _waits(self) -> bool:
        """True where the robot may move, and the firmware does not let it."""
        return self.contract.may_move and not self.link.armed

    @property
    def _permission(self) -> Permission:
        contract = self.contract
        held = not contract.may_move
        return Permission(bool(contract.stopped_by), held, contract.clearances, contract.releases)

    def _hold_where_the_link_was_lost(self) -> None:
        session = self.link.session
        if self._session is not None and session.begun != self._session:
            self._session, self._was_armed = None, False
            self.contract.hold(f"the serial link was lost: {session.ended_by}")
        if session.connected:
            self._session = session.begun

    def _wheel_command(self, now: float) -> WheelCommand:
        if not self.contract.may_move or not self.link.armed:
            # only a command received afterwards is followed
            self._command = None
        if self._command is not None:
            wheel_command = self._command.wheel_command(now, self._settings.limits.command_age)
            if wheel_command is not None:
                return wheel_command
            self._expired += 1
            self._command = None
        return WheelCommand((0.0,) * len(self._wheels), 0.0, self._settings.limits.command_age)

    def _take_telemetry(self, telemetry: Telemetry) -> None:
        begun, self._status = telemetry.status & ~self._status, telemetry.status
        now = self.now()
        for bit, words in LOGGED.items():
            # each by itself: the logger would withhold one for another
            if begun & bit and now - self._warned_at.get(bit, float("-inf")) >= LOG_PERIOD:
                self._warned_at[bit] = now
                self.get_logger().warning(words)
        self._take_stops(telemetry)
        announced = self.link.session.announced
        if self._impacts is None and announced is not None and announced.capabilities & SENSES_IMPACTS:
            self._impacts = SensedImpacts(self, self._inputs, self._settings, self._local_clock)
        if self._impacts is not None:
            self._impacts.take(telemetry)

    def _take_stops(self, telemetry: Telemetry) -> None:
        """Latches, or holds the robot, where the firmware stands still by itself."""
        contract = self.contract
        # by the received telemetry, not the newest: a cause that is over by then has stopped it nevertheless
        status, faults = telemetry.status, _words(FAULTS, telemetry)
        told = self._permission.is_told_by(telemetry)
        armed = told and bool(status & ARMED)
        if status & ESTOP_PRESSED:
            contract.latch("by the button on the robot")
        elif status & ESTOP_LATCHED and told and not contract.stopped_by:
            contract.latch("kept by the firmware")
        elif contract.may_move and faults:
            contract.hold(faults)
        elif contract.may_move and told and self._was_armed and not armed:
            contract.hold("the firmware stands still by itself")
        elif contract.may_move and self.link.session.takes_none_in_time:
            contract.hold(TOO_LATE)
        elif self._unarmed > UNARMED:
            contract.hold("the firmware does not arm" if told else TOO_LATE)
        self._was_armed = armed

    def _faults(self, known: Mapping[int, str]) -> str:
        telemetry = self.link.session.telemetry
        return _words(known, telemetry) if telemetry is not None else ""

    def _report_changes(self, now: float) -> None:
        trouble = self.link.trouble()
        if trouble != self._logged_trouble and now - self._logged_at >= LOG_PERIOD:
            self._logged_trouble, self._logged_at = trouble, now
            log = self.get_logger()
            if trouble:
                log.warning(trouble)
            else:
                log.info("connected, the firmware answers commands")

    # ---- how it is

    def _health(self) -> Health:
        contract = self.contract
        values: dict[str, object] = {**contract.counts, "expired": self._expired, **self._report.values()}
        if self._impacts is not None:
            values |= {"impacts": self._impacts.published, "impacts_missed": self._impacts.missed}
        if self.link.trouble() and not contract.stopped_by:
            return Health(ERROR, self.link.trouble(), values)
        return contract.health(values, self._faults(FAULTS | BATTERY), "connected")

    def stop(self) -> None:
        """Sends zero and waits until it has left."""
        self._command = None
        for _ in range(FINAL_ZEROS):
            now = self.now()
            self._send(now)
        deadline = time.monotonic() + FINAL_WAIT
        while not self.link.drained() and time.monotonic() < deadline:
            time.sleep(0.005)

    def destroy_node(self) -> None:
        """Gives the device back."""
        self.link.close()
        super().destroy_node()


def _words(known: Mapping[int, str], telemetry: Telemetry) -> str:
    return ", ".join(words for bit, words in known.items() if telemetry.status & bit)


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable."""
    return run_node(DriverNode, args)
