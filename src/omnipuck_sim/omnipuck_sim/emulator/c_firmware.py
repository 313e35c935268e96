"""The reference firmware in C around the simulated robot: this is its board. Its clock is the simulator's."""

import ctypes
from collections import deque
from ctypes import POINTER, c_bool, c_char_p, c_float, c_int16, c_size_t, c_uint8, c_uint16, c_uint32, c_void_p

import numpy as np

from collplan_core.impact import Impact
from collplan_core.parameters import Settings
from collplan_core.parameters.spec import ParameterError
from omnipuck_driver.codec import Decoder
from omnipuck_driver.framing import VERSION
from omnipuck_driver.kinematics import OmniWheels
from omnipuck_driver.messages import ARMED, ESTOP_LATCHED, EXPIRED, SENSES_IMPACTS, Telemetry
from omnipuck_sim.emulator.c_library import compiled_firmware
from omnipuck_sim.emulator.firmware import (
    LONGEST_LIFE,
    LOW_BATTERY,
    MOST_ACCELERATION,
    Stop,
    change_in_body,
    measured_wheels,
)
from omnipuck_sim.robot.physics import Simulator

CLOCK = 1 << 32
NAME = b"reference 2"

_CLOCK = ctypes.CFUNCTYPE(c_uint32, c_void_p)
_READ = ctypes.CFUNCTYPE(c_size_t, c_void_p, POINTER(c_uint8), c_size_t)
_WRITE = ctypes.CFUNCTYPE(c_size_t, c_void_p, POINTER(c_uint8), c_size_t)
_WHEELS = ctypes.CFUNCTYPE(None, c_void_p, POINTER(c_float), c_size_t)
_BATTERY = ctypes.CFUNCTYPE(c_uint16, c_void_p)
_TEMPERATURE = ctypes.CFUNCTYPE(c_int16, c_void_p)
_SWITCH = ctypes.CFUNCTYPE(c_bool, c_void_p)
_IMPACT = ctypes.CFUNCTYPE(c_bool, c_void_p, POINTER(c_float), POINTER(c_float))


class _Hardware(ctypes.Structure):
    # as in firmware/hardware.h
    _fields_ = (
        ("context", c_void_p),
        ("clock", _CLOCK),
        ("read", _READ),
        ("write", _WRITE),
        ("set_wheel_speeds", _WHEELS),
        ("measure_wheel_speeds", _WHEELS),
        ("battery", _BATTERY),
        ("temperature", _TEMPERATURE),
        ("emergency_button_pressed", _SWITCH),
        ("motor_fault", _SWITCH),
        ("too_hot", _SWITCH),
        ("take_impact", _IMPACT),
    )


class _Configuration(ctypes.Structure):
    # as in firmware/configuration.h
    _fields_ = (
        ("wheels", c_uint8),
        ("capabilities", c_uint8),
        ("longest_life", c_uint16),
        ("battery_low", c_uint16),
        ("wheel_speed", c_float),
        ("wheel_acceleration", c_float),
        ("firmware", c_char_p),
        ("boot", c_uint32),
    )


class CFirmware:
    """Reference firmware in C with the interface of `Firmware`: takes and gives bytes, and drives `simulator`'s wheels.

    The reason of a stop is known from its telemetry alone.
    """

    def __init__(self, simulator: Simulator, settings: Settings, boot: int) -> None:
        """Compiles the firmware where that is needed; ParameterError: it cannot, or version or wheels do not fit."""
        faults = settings.emulator.asked
        if faults.protocol_version != VERSION:
            raise ParameterError(
                f"emulator.faults: got protocol_version={faults.protocol_version}, expected {VERSION} in C"
            )
        self._wheels = OmniWheels(settings.kinematics)
        if faults.n_wheels not in (0, len(self._wheels)):
            raise ParameterError(
                f"emulator.faults: got n_wheels={faults.n_wheels}, expected 0 or {len(self._wheels)} in C"
            )
        self.estop_pressed = faults.estop_pressed
        self.battery = faults.battery
        self.motor_fault, self.too_hot = faults.motor_fault, faults.too_hot
        self.stalled = False  # held up since the last telemetry
        self._simulator = simulator
        self._speeds = np.zeros(len(self._wheels))
        self._incoming, self._outgoing = b"", b""
        self._impacts: deque[tuple[float, float]] = deque()
        self._stops: list[Stop] = []
        self._stepped_at = simulator.time
        # what the firmware keeps pointers to
        self._library = compiled_firmware()
        self._configuration = _Configuration(
            wheels=len(self._wheels),
            capabilities=SENSES_IMPACTS if settings.emulator.senses_impacts else 0,
            longest_life=round(LONGEST_LIFE * 1e3),
            battery_low=round(LOW_BATTERY * 1e3),
            wheel_speed=settings.kinematics.max_wheel_speed,
            wheel_acceleration=MOST_ACCELERATION,
            firmware=NAME,
            boot=boot,
        )
        self._hardware = _Hardware(
            context=None,
            clock=_CLOCK(lambda _: round(self._simulator.time * 1e3) % CLOCK),
            read=_READ(self._read),
            write=_WRITE(self._write),
            set_wheel_speeds=_WHEELS(self._set_wheel_speeds),
            measure_wheel_speeds=_WHEELS(self._measure_wheel_speeds),
            battery=_BATTERY(lambda _: round(self.battery * 1e3)),
            temperature=_TEMPERATURE(),
            emergency_button_pressed=_SWITCH(lambda _: self.estop_pressed),
            motor_fault=_SWITCH(lambda _: self.motor_fault),
            too_hot=_SWITCH(lambda _: self.too_hot),
            take_impact=_IMPACT(self._take_impact),
        )
        self._library.omnipuck_host_state_size.restype = c_size_t
        self._library.omnipuck_host_command_age.restype = c_uint32
        self._state = ctypes.create_string_buffer(self._library.omnipuck_host_state_size())
        self._library.omnipuck_start.restype = c_bool
        board = ctypes.byref(self._configuration), ctypes.byref(self._hardware)
        if not self._library.omnipuck_start(self._state, *board):
            raise ParameterError("kinematics: the reference firmware refuses number of wheels or max_wheel_speed")

    def booted(self) -> bytes:
        """The announcement after a start."""
        return self.receive(b"")

    def receive(self, data: bytes) -> bytes:
        """Takes bytes; returns the bytes sent since the last call."""
        self._incoming += data
        self._step()
        while self._incoming:
            self._step()
        return self._taken()

    def advance(self) -> None:
        """Steps the firmware; to be called before each step of the simulator."""
        self._step()

    def end(self) -> None:
        """Switches the firmware off."""
        if self._speeds.any():
            now = self._simulator.time
            self._stops.append(Stop(now, now - self._born(), "restart"))
            self._speeds = np.zeros(len(self._wheels))
            self._simulator.command(np.zeros(2), 0.0)

    def sense(self, impact: Impact) -> None:
        """Keeps an impact until the firmware asks for it, where the ring has a sensor."""
        if self._configuration.capabilities & SENSES_IMPACTS:
            self._impacts.append(change_in_body(impact, self._simulator))

    def take_stops(self) -> list[Stop]:
        """The stops since the last call, in order."""
        taken, self._stops = self._stops, []
        return taken

    def telemetry(self) -> bytes:
        """Returns the bytes sent since the last call, and one frame of telemetry."""
        if self.stalled:
            self._library.omnipuck_host_hold_up(self._state)
            self.stalled = False
        self._library.omnipuck_host_ask_for_telemetry(self._state)
        self._step()
        return self._taken()

    def counts(self) -> dict[str, int]:
        """Empty: the firmware in C counts only what its telemetry reports."""
        return {}

    def _taken(self) -> bytes:
        taken, self._outgoing = self._outgoing, b""
        return taken

    def _step(self) -> None:
        turned, born = self._speeds.any(), self._born()
        self._library.omnipuck_step(self._state)
        self._stepped_at = self._simulator.time
        if turned and not self._speeds.any():
            self._stops.append(Stop(self._stepped_at, self._stepped_at - born, self._cause()))

    def _born(self) -> float:
        return self._stepped_at - 1e-3 * self._library.omnipuck_host_command_age(self._state)

    def _cause(self) -> str:
        """Returns the reason why it has stopped, from its telemetry."""
        before = len(self._outgoing)
        self._library.omnipuck_host_ask_for_telemetry(self._state)
        self._library.omnipuck_step(self._state)
        (*_, told) = (each for each in Decoder().feed(self._outgoing[before:]) if isinstance(each, Telemetry))
        causes = {
            "emergency stop": bool(told.status & ESTOP_LATCHED),
            "motor fault": self.motor_fault,
            "too hot": self.too_hot,
            "session": not told.session or not told.echo,
            "life": bool(told.status & EXPIRED),
            "hold": not told.status & ARMED,
        }
        return next((cause for cause, is_so in causes.items() if is_so), "command")

    # ---- the board

    def _read(self, _: None, to: "ctypes._Pointer[c_uint8]", capacity: int) -> int:
        data, self._incoming = self._incoming[:capacity], self._incoming[capacity:]
        ctypes.memmove(to, data, len(data))
        return len(data)

    def _write(self, _: None, data: "ctypes._Pointer[c_uint8]", length: int) -> int:
        self._outgoing += ctypes.string_at(data, length)
        return length

    def _set_wheel_speeds(self, _: None, speeds: "ctypes._Pointer[c_float]", n: int) -> None:
        self._speeds = np.array(speeds[:n], dtype=float)
        velocity, yaw_rate = self._wheels.twist(self._speeds)
        self._simulator.command(velocity, yaw_rate)

    def _measure_wheel_speeds(self, _: None, to: "ctypes._Pointer[c_float]", n: int) -> None:
        measured = measured_wheels(self._wheels, self._simulator)
        for i in range(n):
            to[i] = measured[i]

    def _take_impact(self, _: None, x: "ctypes._Pointer[c_float]", y: "ctypes._Pointer[c_float]") -> bool:
        if not self._impacts:
            return False
        x[0], y[0] = self._impacts.popleft()
        return True
