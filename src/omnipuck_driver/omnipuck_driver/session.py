"""The driver's end of the protocol, without a port: greeting, acceptance, sending, and the life of a command."""

import secrets
from collections.abc import Callable
from dataclasses import dataclass

from omnipuck_driver.codec import Decoder, Encoder
from omnipuck_driver.framing import VERSION
from omnipuck_driver.messages import (
    ACTS,
    ARMED,
    EMERGENCY_STOP,
    ESTOP_PRESSED,
    FROM_DEVICE,
    HOLD,
    Announce,
    CommandMessage,
    Hello,
    Telemetry,
    WheelCaps,
)

HELLO_PERIOD = 0.1
"""Time between two greetings [s]."""
LONGEST_ECHO_DELAY = 1000
"""Time since the firmware took a command, beyond which none is taken in time [ms]."""
TOO_LATE = "the firmware takes no command in time: raise driver.baud, lower driver.rate, or check the line"
"""Reason why nothing moves where commands arrive late and are dropped."""
MILLISECONDS = 1 << 32


@dataclass(frozen=True)
class WheelCommand:
    """The wheel speeds to be sent."""

    wheels: tuple[float, ...]  # speeds [rad/s]
    age: float  # of the velocity command behind them [s]
    life: float  # remaining time for which they may be followed [s]

    def standing_still(self) -> "WheelCommand":
        """Copy of the command with all wheel speeds 0."""
        return WheelCommand((0.0,) * len(self.wheels), self.age, self.life)


@dataclass(frozen=True)
class Permission:
    """Permission that a person gives the robot; it goes with every command."""

    stopped: bool  # the emergency stop is latched
    held: bool  # the robot waits until a person lets it move
    cleared: int  # number of times that the emergency stop was cleared
    released: int  # number of times that a person has let the robot move

    @property
    def flags(self) -> int:
        """The flags of a command."""
        return (EMERGENCY_STOP if self.stopped else 0) | (HOLD if self.held else 0)

    def is_told_by(self, telemetry: Telemetry) -> bool:
        """Returns whether the firmware had received it when it sent this: only then can its status be compared."""
        acts = self.cleared % ACTS, self.released % ACTS
        return bool(telemetry.echo) and (telemetry.cleared, telemetry.released) == acts


def _new_token() -> int:
    return secrets.randbelow((1 << 32) - 1) + 1


class Session:
    """One conversation with the firmware at a time, with a robot of `n_wheels`.

    It begins with a Hello and a token that the firmware repeats in each message; a message with another token belongs
    to an earlier conversation. Only zero is sent until the firmware reports that it is armed. After a silence of
    `timeout` [s] a new session begins; `new_token` draws tokens, never 0.
    """

    def __init__(
        self, n_wheels: int, timeout: float, caps: WheelCaps, new_token: Callable[[], int] = _new_token
    ) -> None:
        self.announced: Announce | None = None  # the firmware's answer
        self.telemetry: Telemetry | None = None  # its newest in this session
        self.latency: float | None = None  # from sending a command to its echo, without the firmware's own time [s]
        self.begun = 0  # sessions so far
        self.decoder = Decoder(kinds=FROM_DEVICE)
        self._encoder = Encoder()
        self._n_wheels = n_wheels
        self._timeout = timeout
        self._caps = caps
        self._new_token = new_token
        self.begin("nothing was sent yet")

    def begin(self, ended_by: str) -> None:
        """Begins a new session with a greeting; `ended_by` is the reason why the previous one has ended."""
        self.begun += 1
        self.ended_by = ended_by
        self.announced = self.telemetry = self.latency = None
        self.decoder.forget()
        self._token = self._new_token()
        self._heard = self._greeted = float("-inf")
        self._taken_before = self.decoder.taken
        self._accepted_before = self.decoder.accepted

    @property
    def connected(self) -> bool:
        """True where a firmware that fits the robot has answered."""
        announced = self.announced
        return announced is not None and announced.n_wheels == self._n_wheels and self._keeps_caps(announced)

    @property
    def armed(self) -> bool:
        """True where the firmware follows commands other than zero."""
        return self.connected and self.telemetry is not None and bool(self.telemetry.status & ARMED)

    @property
    def takes_none_in_time(self) -> bool:
        """True where the firmware took commands in this session and takes none any more, as where all come late."""
        telemetry = self.telemetry
        return telemetry is not None and bool(telemetry.echo) and telemetry.echo_delay > LONGEST_ECHO_DELAY

    @property
    def button_pressed(self) -> bool:
        """True where the emergency stop on the robot is pressed."""
        return self.telemetry is not None and bool(self.telemetry.status & ESTOP_PRESSED)

    def receive(self, data: bytes, now: float) -> list[Telemetry]:
        """Takes bytes at the local time `now` [s]; returns the telemetry of this session among them."""
        news = []
        for message in self.decoder.feed(data):
            if isinstance(message, Announce):
                self._heard = now
                self._take_announcement(message)
            elif isinstance(message, Telemetry):
                self._heard = now
                if self._is_of_this_session(message):
                    self._measure(message, now)
                    self.telemetry = message
                    news.append(message)
        return news

    def outgoing(self, wheel_command: WheelCommand, permission: Permission, now: float) -> bytes:
        """Returns the bytes to send at the local time `now` [s]: a greeting, zero, or the wheel command."""
        if self.announced is not None and now - self._heard > self._timeout:
            self.begin("the firmware fell silent")
        if not self.connected:
            return self._greeting(now)
        allowed = wheel_command if self.armed else wheel_command.standing_still()
        return self._encoder.encode(
            CommandMessage(
                session=self._token,
                sent=_milliseconds(now) % MILLISECONDS,
                age=min(_milliseconds(allowed.age), 0xFFFF),
                life=min(max(_milliseconds(allowed.life), 1), 0xFFFF),
                flags=permission.flags,
                cleared=permission.cleared % ACTS,
                released=permission.released % ACTS,
                wheels=allowed.wheels,
            )
        )

    def trouble(self) -> str:
        """Returns the reason why nothing can move; "" while the firmware answers commands."""
        if self.announced is None:
            return self._why_no_answer()
        if self.announced.n_wheels != self._n_wheels:
            return (
                f"the firmware has {self.announced.n_wheels} wheels, kinematics.wheel_angles {self._n_wheels}: "
                "correct the parameter"
            )
        if not self._keeps_caps(self.announced):
            return f"the firmware lets through {self.announced.caps}, more than the {self._caps} requested"
        if self.button_pressed:
            return "the emergency stop on the robot is pressed"
        if self.telemetry is None or not self.telemetry.echo:
            return "waiting until the firmware takes commands"
        return TOO_LATE if self.takes_none_in_time else ""

    def _why_no_answer(self) -> str:
        if self.decoder.other_version is not None:
            return (
                f"the firmware speaks version {self.decoder.other_version} of the protocol, this driver version "
                f"{VERSION}: install a firmware and a driver of one version"
            )
        if self.decoder.accepted > self._accepted_before:
            return "bytes of the firmware are received, but no answer: is the line to it connected?"
        if self.decoder.taken > self._taken_before:
            return "bytes arrive but make no whole frames: is driver.baud that of the firmware, and this its device?"
        return "no answer: is the robot switched on, does it run the firmware?"

    def _take_announcement(self, message: Announce) -> None:
        if message.session == self._token:
            self.announced = message
            self.decoder.other_version = None
        elif self.announced is not None:
            self.begin("the firmware has restarted")

    def _is_of_this_session(self, message: Telemetry) -> bool:
        if self.announced is None:
            return False
        if (message.session, message.boot) == (self._token, self.announced.boot):
            return True
        restarted = message.boot != self.announced.boot
        self.begin("the firmware has restarted" if restarted else "the firmware has ended the session")
        return False

    def _keeps_caps(self, announced: Announce) -> bool:
        return announced.caps.within(self._caps) == announced.caps

    def _measure(self, message: Telemetry, now: float) -> None:
        if message.echo:
            there_and_back = (_milliseconds(now) - message.echo) % MILLISECONDS
            self.latency = max(there_and_back - message.echo_delay, 0) * 1e-3

    def _greeting(self, now: float) -> bytes:
        if now - self._greeted < HELLO_PERIOD:
            return b""
        self._greeted = now
        return self._encoder.encode(Hello(self._token, self._caps))


def _milliseconds(seconds: float) -> int:
    return round(seconds * 1e3)


@dataclass(frozen=True)
class HeldCommand:
    """Wheel speeds [rad/s] and the time of their command [s, local clock]."""

    wheels: tuple[float, ...]
    given: float

    def wheel_command(self, now: float, longest_age: float) -> WheelCommand | None:
        """The wheel command to send at `now` [s]; None once the command is older than `longest_age` [s]."""
        age = now - self.given
        return WheelCommand(self.wheels, age, longest_age - age) if age < longest_age else None
