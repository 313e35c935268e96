"""The emulated firmware behind a real pseudo-terminal, in the room of the simulated robot, with faults on request."""

import secrets
import time
from collections import Counter
from collections.abc import Sequence
from math import floor
from pathlib import Path
from typing import Any

from std_srvs.srv import Trigger

from collplan_core.parameters import (
    Control,
    Emulator,
    EmulatorFaults,
    Frames,
    Kinematics,
    Limits,
    Robot,
    Settings,
    Simulation,
)
from collplan_core.parameters.spec import ParameterError
from collplan_ros.node_kit.diagnostics import WARN, Health
from collplan_ros.node_kit.graph_node import GraphNode
from collplan_ros.node_kit.run_node import run_node
from omnipuck_sim.emulator.c_firmware import CFirmware
from omnipuck_sim.emulator.faults import BadLine
from omnipuck_sim.emulator.firmware import Firmware, Stop
from omnipuck_sim.emulator.pseudo_terminal import PseudoTerminal
from omnipuck_sim.node.simulated_mocap import MOCAP_LIVE, SimulatedMocap

FIRMWARES: dict[str, type[Firmware] | type[CFirmware]] = {"python": Firmware, "c": CFirmware}
GROUPS = (Robot, Simulation, Limits, Control, Frames, Kinematics, Emulator)
GARBLED = EmulatorFaults(flipped=0.5)
"""Faults of a line whose ends use different rates."""
TELEMETRY_RATE = 50.0
"""Telemetry frames per second, as the reference in C sends them."""


class FirmwareEmulator(GraphNode):
    """Once per pose it reads the driver's bytes, moves the robot, and answers.

    Each time the wheels are set to zero after they had turned, its diagnostics report at once: `stops`, `stop_age` (of
    the command then), `stop_cause`, and `time_stalled`, all on the simulation's clock.
    """

    def __init__(self, **kwargs: Any) -> None:
        """Keyword arguments go to `rclpy.node.Node`."""
        super().__init__("firmware_emulator", GROUPS, (Emulator, *MOCAP_LIVE), **kwargs)
        if self._settings.simulator.speed_factor != 1.0:
            raise ParameterError("simulator.speed_factor: expected 1 with the emulated firmware, a line has real time")
        self._room = SimulatedMocap(self, self._settings)
        self._line_in, self._line_out = (BadLine(2 * self._settings.simulator.seed + way) for way in (0, 1))
        self._terminal: PseudoTerminal | None = None
        self._telemetry_sent = 0
        self._stops: Counter[str] = Counter()
        self._last_stop: Stop | None = None
        self._firmware = self._started()
        self._plug()
        self.create_service(Trigger, "reset", self._reset)
        self._room.start(self._advance)
        self._begin()
        link = self._settings.emulator.link
        self.get_logger().info(f"ready: {link} leads to the firmware; {self._room.description}")

    # ---- faults on request

    def _change(self, settings: Settings) -> None:
        before, faults = self._settings.emulator.asked, settings.emulator.asked
        self._settings = settings
        if faults.restarts not in (0, before.restarts):
            self.get_logger().info("the firmware starts again")
            self._restart()
        if faults.unplugged != before.unplugged:
            self.get_logger().info(f"the cable is {'pulled' if faults.unplugged else 'plugged in'}")
            self._plug()
        if faults.estop_pressed > before.estop_pressed:
            self.get_logger().warning("the emergency stop on the robot is pressed")
        if faults.estop_pressed < before.estop_pressed:
            self.get_logger().info("the emergency stop on the robot is released")
        if faults.stall != before.stall:
            time.sleep(faults.stall)
        self._firmware.estop_pressed, self._firmware.battery = faults.estop_pressed, faults.battery
        self._firmware.motor_fault, self._firmware.too_hot = faults.motor_fault, faults.too_hot

    def _started(self) -> Firmware | CFirmware:
        kind = FIRMWARES[self._settings.emulator.firmware]
        return kind(self._room.simulator, self._settings, secrets.randbits(32))

    def _restart(self) -> None:
        self._firmware.end()
        self._take_stops()
        self._firmware = self._started()
        self._write(self._firmware.booted())

    def _plug(self) -> None:
        if self._terminal is not None:
            self._terminal.close()
            self._terminal = None
        if not self._settings.emulator.asked.unplugged:
            self._terminal = PseudoTerminal(Path(self._settings.emulator.link))
            self._write(self._firmware.booted())

    # ---- the line

    def _read(self) -> bytes:
        if self._terminal is None:
            return b""
        return self._line_in.passed(self._terminal.read(), self._faults(self._terminal))

    def _write(self, data: bytes) -> None:
        if self._terminal is not None:
            self._terminal.write(self._line_out.passed(data, self._faults(self._terminal)))

    def _faults(self, terminal: PseudoTerminal) -> EmulatorFaults:
        faults = self._settings.emulator.asked
        return faults if terminal.rate_is(faults.baud) else GARBLED

    # ---- time

    def _advance(self) -> None:
        stalled = self._room.stalled
        impacts = self._room.advance(self._firmware.advance)
        self._firmware.stalled |= self._room.stalled > stalled
        for impact in impacts:
            self._firmware.sense(impact)
        self._write(self._firmware.receive(self._read()))
        self._send_telemetry()
        self._take_stops()

    def _send_telemetry(self) -> None:
        due = floor(self._room.simulator.time * TELEMETRY_RATE + 1e-6)
        if due > self._telemetry_sent:
            self._telemetry_sent = due
            self._write(self._firmware.telemetry())

    def _take_stops(self) -> None:
        for stop in self._firmware.take_stops():
            self._stops[stop.cause] += 1
            if stop.cause != "command":
                text = f"stopped, cause: {stop.cause}, command {stop.age:.2f} s old"
                self.get_logger().warning(text, throttle_duration_sec=1.0)
            self._last_stop = stop
            self._diagnostics.publish()

    def _reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._room.simulator.reset()
        response.success, response.message = True, "carried back to the start, at rest"
        self.get_logger().info(f"reset: {response.message}")
        return response

    # ---- state

    def _health(self) -> Health:
        stop, firmware = self._last_stop, self._firmware
        values: dict[str, object] = {
            **firmware.counts(),
            "impacts": self._room.impacts,
            "simulated_time": self._room.simulator.time,
            "time_stalled": self._room.stalled,
            "stops": sum(self._stops.values()),
        }
        if stop is not None:
            values |= {"stop_time": stop.time, "stop_age": stop.age, "stop_cause": stop.cause}
        return Health.of(values, "simulated", (WARN, "unplugged" if self._settings.emulator.asked.unplugged else ""))

    def destroy_node(self) -> None:
        """Takes the pseudo-terminal away."""
        if self._terminal is not None:
            self._terminal.close()
            self._terminal = None
        super().destroy_node()


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable."""
    return run_node(FirmwareEmulator, args)
