"""The driver's end of the protocol, without a port: when to greet, what to accept, what to send."""

import secrets
from collections.abc import Callable
from dataclasses import dataclass

from omnipuck_driver.codec import Decoder, Encoder
from omnipuck_driver.framing import VERSION
from omnipuck_driver.messages import ARMED, EMERGENCY_STOP, ESTOP_PRESSED, Announce, CommandMessage, Hello, Telemetry

HELLO_PERIOD = 0.1
"""Time between two greetings [s]."""
MILLISECONDS = 1 << 32


@dataclass(frozen=True)
class WheelCommand:
    """The wheel speeds to be sent.

    Attributes:
        wheels: speeds [rad/s].
        age: age of the velocity command behind them [s].
        life: how much longer they may be followed [s].
        emergency_stop: stand still whatever comes, until a wheel command without it.
    """

    wheels: tuple[float, ...]
    age: float
    life: float
    emergency_stop: bool = False

    def standing_still(self) -> "WheelCommand":
        """This command with the wheels at rest."""
        return WheelCommand((0.0,) * len(self.wheels), self.age, self.life, self.emergency_stop)


def _new_token() -> int:
    return secrets.randbelow((1 << 32) - 1) + 1


class Session:
    """One conversation with the firmware at a time.

    It begins with a Hello and a token that the firmware repeats in each message; a message with another token belongs
    to an earlier conversation. Only after the firmware has taken a zero command in this session are others sent.

    Args:
        n_wheels: number of wheels that the robot should have.
        timeout: silence after which a new session begins [s].
        new_token: draws tokens, never 0.

    Attributes:
        announced: the firmware's answer, None before.
        telemetry: its newest in this session, None before.
        latency: from sending a command to the telemetry that echoes it, without the firmware's own time [s].
        begun: sessions so far.
    """

    def __init__(self, n_wheels: int, timeout: float, new_token: Callable[[], int] = _new_token) -> None:
        self.announced: Announce | None = None
        self.telemetry: Telemetry | None = None
        self.latency: float | None = None
        self.begun = 0
        self.decoder = Decoder()
        self._encoder = Encoder()
        self._n_wheels = n_wheels
        self._timeout = timeout
        self._new_token = new_token
        self.begin()

    def begin(self) -> None:
        """Begins a new session with a greeting, as after a reconnect."""
        self.begun += 1
        self.announced = self.telemetry = self.latency = None
        self.decoder.forget()
        self._token = self._new_token()
        self._heard = self._greeted = float("-inf")
        self._taken_before = self.decoder.taken

    @property
    def connected(self) -> bool:
        """Whether a firmware has answered that fits the robot."""
        return self.announced is not None and self.announced.n_wheels == self._n_wheels

    @property
    def armed(self) -> bool:
        """Whether the firmware follows commands other than zero."""
        return self.connected and self.telemetry is not None and bool(self.telemetry.status & ARMED)

    @property
    def button_pressed(self) -> bool:
        """Whether the emergency stop on the robot is pressed."""
        return self.telemetry is not None and bool(self.telemetry.status & ESTOP_PRESSED)

    def receive(self, data: bytes, now: float) -> list[Telemetry]:
        """Takes bytes at the local time `now` [s]; the telemetry of this session among them."""
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

    def outgoing(self, wheel_command: WheelCommand, now: float) -> bytes:
        """The bytes to send at the local time `now` [s]: a greeting, zero, or the wheel command."""
        if self.announced is not None and now - self._heard > self._timeout:
            self.begin()
        if not self.connected:
            return self._greeting(now)
        allowed = wheel_command if self.armed else wheel_command.standing_still()
        return self._encoder.encode(
            CommandMessage(
                session=self._token,
                sent=_milliseconds(now) % MILLISECONDS,
                age=min(_milliseconds(allowed.age), 0xFFFF),
                life=min(max(_milliseconds(allowed.life), 1), 0xFFFF),
                flags=EMERGENCY_STOP if allowed.emergency_stop else 0,
                wheels=allowed.wheels,
            )
        )

    def trouble(self) -> str:
        """Why nothing can move, in words; empty while the firmware follows commands."""
        if self.announced is None:
            return self._why_no_answer()
        if not self.connected:
            return (
                f"the firmware has {self.announced.n_wheels} wheels, kinematics.wheel_angles {self._n_wheels}: "
                "correct the parameter"
            )
        if self.button_pressed:
            return "the emergency stop on the robot is pressed"
        return "" if self.armed else "waiting until the firmware has taken a zero command"

    def _why_no_answer(self) -> str:
        if self.decoder.other_version is not None:
            return (
                f"the firmware speaks version {self.decoder.other_version} of the protocol, this driver version "
                f"{VERSION}: install a firmware and a driver of one version"
            )
        if self.decoder.taken > self._taken_before:
            return "bytes come in but make no whole frames: is driver.baud that of the firmware, and this its device?"
        return "no answer: is the robot switched on, does it run the firmware?"

    def _take_announcement(self, message: Announce) -> None:
        if message.session == self._token:
            self.announced = message
            self.decoder.other_version = None
        elif self.announced is not None:  # it has restarted
            self.begin()

    def _is_of_this_session(self, message: Telemetry) -> bool:
        if self.announced is None:
            return False
        if (message.session, message.boot) == (self._token, self.announced.boot):
            return True
        self.begin()
        return False

    def _measure(self, message: Telemetry, now: float) -> None:
        if message.echo:
            there_and_back = (_milliseconds(now) - message.echo) % MILLISECONDS
            self.latency = max(there_and_back - message.echo_delay, 0) * 1e-3

    def _greeting(self, now: float) -> bytes:
        if now - self._greeted < HELLO_PERIOD:
            return b""
        self._greeted = now
        return self._encoder.encode(Hello(self._token))


def _milliseconds(seconds: float) -> int:
    return round(seconds * 1e3)
