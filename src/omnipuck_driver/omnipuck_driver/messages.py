"""The messages of the protocol and their bytes. See docs/protocol.md."""

import math
import struct
from dataclasses import dataclass
from typing import ClassVar

from omnipuck_driver.framing import FrameError

MOST_WHEELS = 8
NEVER = 0xFFFF
"""An age [ms] that does not exist, or is longer than its field can hold."""
NO_TEMPERATURE = 0x7FFF

# status bits of telemetry: EXPIRED, the last command outlived its life; STALLED, it was held up since the last one
ARMED, ESTOP_PRESSED, BATTERY_LOW, EXPIRED, STALLED, MOTOR_FAULT, TOO_HOT, ESTOP_LATCHED = (1 << n for n in range(8))
# capability bits of an announcement
SENSES_IMPACTS, GIVES_TEMPERATURE = 1, 2
# flags of a command
EMERGENCY_STOP, HOLD = 1, 2
ACTS = 1 << 8
"""Modulus of the counts of a person's actions."""

_HELLO = struct.Struct("<Iff")
_COMMAND = struct.Struct("<IIHHBBBB")
_ANNOUNCE = struct.Struct("<IIBBHff12s")
_TELEMETRY = struct.Struct("<IIIHHhIHHHHHHffBBB")


@dataclass(frozen=True)
class WheelCaps:
    """Hard limits of every wheel, each exactly a 32-bit float."""

    speed: float  # [rad/s]
    acceleration: float  # of a wheel that is commanded to turn faster [rad/s^2]

    def __post_init__(self) -> None:
        _check_finite(self.speed, self.acceleration)
        if self.speed <= 0.0 or self.acceleration <= 0.0:
            raise FrameError("content", f"caps {self.speed}, {self.acceleration}, expected more than 0")

    def within(self, other: "WheelCaps") -> "WheelCaps":
        """Returns the smaller of each limit."""
        return WheelCaps(min(self.speed, other.speed), min(self.acceleration, other.acceleration))


@dataclass(frozen=True)
class Hello:
    """Driver to device: begin a session. The device ends the one before and stands still."""

    KIND: ClassVar[int] = 0x01
    session: int  # token of the session
    caps: WheelCaps  # whatever is commanded in the session

    def pack(self) -> bytes:
        """The payload."""
        return _HELLO.pack(self.session, self.caps.speed, self.caps.acceleration)

    @classmethod
    def unpack(cls, payload: bytes) -> "Hello":
        """The message of a payload; raises `struct.error` or `FrameError` where it is none."""
        session, speed, acceleration = _HELLO.unpack(payload)
        return cls(session, WheelCaps(speed, acceleration))


@dataclass(frozen=True)
class CommandMessage:
    """Driver to device: turn the wheels. `Command` in docs/protocol.md."""

    KIND: ClassVar[int] = 0x02
    session: int  # token of the session
    sent: int  # driver's clock [ms, modulo 2^32]
    age: int  # age of the command behind it when it was sent [ms]
    life: int  # remaining time for which it may be followed [ms]
    flags: int  # EMERGENCY_STOP: stand still, latch and disarm; HOLD: stand still and disarm
    cleared: int  # clearances of the emergency stop by a person, modulo ACTS; a change in a session clears it
    released: int  # releases of the robot by a person, modulo ACTS; a change in a session arms it
    wheels: tuple[float, ...]  # speeds [rad/s]

    def pack(self) -> bytes:
        """The payload."""
        times, acts = (self.session, self.sent, self.age, self.life), (self.cleared, self.released)
        return _COMMAND.pack(*times, self.flags, *acts, len(self.wheels)) + _pack_wheels(self.wheels)

    @classmethod
    def unpack(cls, payload: bytes) -> "CommandMessage":
        """The message of a payload; raises `struct.error` or `FrameError` where it is none."""
        *head, count = _COMMAND.unpack_from(payload)
        return cls(*(*head, _unpack_wheels(payload[_COMMAND.size :], count)))


@dataclass(frozen=True)
class Announce:
    """Device to driver: its description; the answer to Hello, and sent unrequested with session 0 after a start."""

    KIND: ClassVar[int] = 0x81
    session: int  # token of the Hello it answers, else 0
    boot: int  # another number after each start
    capabilities: int  # SENSES_IMPACTS, GIVES_TEMPERATURE
    n_wheels: int
    longest_life: int  # it shortens longer lives of commands to this [ms]
    caps: WheelCaps  # in this session: the smaller of the requested ones and its own
    firmware: str  # name and version, up to 12 ASCII characters

    def pack(self) -> bytes:
        """The payload."""
        name = self.firmware.encode("ascii")
        what = self.session, self.boot, self.capabilities, self.n_wheels, self.longest_life
        return _ANNOUNCE.pack(*what, self.caps.speed, self.caps.acceleration, name)

    @classmethod
    def unpack(cls, payload: bytes) -> "Announce":
        """The message of a payload; raises `struct.error` or `FrameError` where it is none."""
        *head, speed, acceleration, name = _ANNOUNCE.unpack(payload)
        firmware = name.rstrip(b"\0").decode("ascii", errors="replace")
        return cls(*(*head, WheelCaps(speed, acceleration), firmware))


@dataclass(frozen=True)
class Telemetry:
    """Device to driver: its state, at a steady rate."""

    KIND: ClassVar[int] = 0x82
    session: int  # the present one, 0 before the first Hello
    boot: int  # another number after each start
    time: int  # device's clock [ms, modulo 2^32]
    status: int  # ARMED, ..., as above
    battery: int  # voltage [mV]
    temperature: int  # [0.1 deg C], NO_TEMPERATURE where it measures none
    echo: int  # `sent` of the newest command of the session that came in time, 0 before the first
    echo_delay: int  # time since it came [ms]
    command_age: int  # of the command behind the wheels' motion [ms], NEVER while they stand still
    accepted: int  # frames that came, modulo 2^16
    dropped: int  # likewise
    impacts: int  # sensed so far, modulo 2^16
    impact_age: int  # time since the newest impact [ms], NEVER where there is none
    impact: tuple[float, float]  # its change of velocity in the body frame of then, x forward, y left [m/s]
    cleared: int  # count of the newest command taken in this session, 0 before one
    released: int  # likewise
    wheels: tuple[float, ...]  # measured speeds [rad/s]

    def pack(self) -> bytes:
        """The payload."""
        state = self.session, self.boot, self.time, self.status, self.battery, self.temperature
        commands = self.echo, self.echo_delay, self.command_age, self.accepted, self.dropped
        impact = self.impacts, self.impact_age, *self.impact
        acts = self.cleared, self.released
        return _TELEMETRY.pack(*state, *commands, *impact, *acts, len(self.wheels)) + _pack_wheels(self.wheels)

    @classmethod
    def unpack(cls, payload: bytes) -> "Telemetry":
        """The message of a payload; raises `struct.error` or `FrameError` where it is none."""
        *head, x, y, cleared, released, count = _TELEMETRY.unpack_from(payload)
        _check_finite(x, y)
        return cls(*(*head, (x, y), cleared, released, _unpack_wheels(payload[_TELEMETRY.size :], count)))


Message = Hello | CommandMessage | Announce | Telemetry
Kinds = tuple[type[Hello] | type[CommandMessage] | type[Announce] | type[Telemetry], ...]
TO_DEVICE: Kinds = (Hello, CommandMessage)
FROM_DEVICE: Kinds = (Announce, Telemetry)


def unpack_message(kind: int, payload: bytes, kinds: Kinds = TO_DEVICE + FROM_DEVICE) -> Message:
    """The message of a frame, whose type is `kind`; `kinds` are the messages that may come.

    FrameError: a type that is not among them, a length that does not fit, or numbers that are not finite.
    """
    message = next((each for each in kinds if kind == each.KIND), None)
    if message is None:
        raise FrameError("type", f"type 0x{kind:02x} is unknown")
    try:
        return message.unpack(payload)
    except struct.error as error:
        raise FrameError("content", f"type 0x{kind:02x}: {error}") from None


def _pack_wheels(wheels: tuple[float, ...]) -> bytes:
    return struct.pack(f"<{len(wheels)}f", *wheels)


def _unpack_wheels(rest: bytes, count: int) -> tuple[float, ...]:
    if count > MOST_WHEELS:
        raise FrameError("content", f"{count} wheels, expected at most {MOST_WHEELS}")
    wheels = struct.unpack(f"<{count}f", rest)
    _check_finite(*wheels)
    return wheels


def _check_finite(*values: float) -> None:
    if not all(map(math.isfinite, values)):
        raise FrameError("content", f"got {values}, expected finite numbers")
