"""The firmware's end of the protocol around the simulated robot, without a port. Its clock is the simulator's."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.plane import rotate
from omnipuck_driver.codec import Decoder, Encoder
from omnipuck_driver.kinematics import OmniWheels
from omnipuck_driver.messages import (
    ARMED,
    BATTERY_LOW,
    EMERGENCY_STOP,
    ESTOP_PRESSED,
    EXPIRED,
    NEVER,
    NO_TEMPERATURE,
    SENSES_IMPACTS,
    STALLED,
    Announce,
    CommandMessage,
    Hello,
    Telemetry,
)
from omnipuck_sim.robot.impact import Impact
from omnipuck_sim.robot.physics import Simulator

LONGEST_LIFE = 0.5
"""Longest life of a command, whatever it asks for [s]."""
SESSION_TIMEOUT = 1.0
"""Silence after which a session is over [s]."""
LOW_BATTERY = 6.6
"""Voltage below which the battery is reported as low [V]."""
DRIFT = 1e-3
"""Rate by which the driver's clock may be slow [s/s]."""
COUNTS = 1 << 16
CLOCK = 1 << 32


@dataclass(frozen=True)
class Stop:
    """The wheels were set to zero after they had turned.

    Attributes:
        time: when it was [s].
        age: age of the last command followed, since the driver took it [s].
        cause: command, life, emergency stop, session or restart.
    """

    time: float
    age: float
    cause: str


class Firmware:
    """The firmware: takes and gives bytes, and drives the wheels of `simulator`.

    Attributes:
        estop_pressed: whether the button on the robot is pressed.
        battery: its voltage [V].
        stalled: whether the firmware was held up since the last telemetry.
        refused: commands that came whole and were not followed.
        late: refused commands that had outlived their life on the way.
    """

    def __init__(self, simulator: Simulator, settings: Settings, boot: int) -> None:
        emulator = settings.emulator
        self.estop_pressed = emulator.estop_pressed
        self.battery = emulator.battery
        self.stalled = False
        self.refused = 0
        self.late = 0
        self._simulator = simulator
        self._wheels = OmniWheels(settings.kinematics)
        self._n_wheels = emulator.n_wheels or len(self._wheels)
        self._senses = emulator.senses_impacts
        self._boot = boot
        version = emulator.protocol_version
        self._encoder, self._decoder = Encoder(version), Decoder(version)
        self._session = 0
        self._armed = False
        self._expired = False
        self._heard = 0.0
        self._delay = float("inf")
        self._echo: tuple[int, float] | None = None
        self._speeds = np.zeros(len(self._wheels))
        self._expires = 0.0
        self._born = 0.0
        self._impacts = 0
        self._impact: tuple[float, tuple[float, float]] | None = None
        self._stops: list[Stop] = []

    def booted(self) -> bytes:
        """The announcement after a start."""
        return self._announcement(0)

    def receive(self, data: bytes) -> bytes:
        """Takes bytes; returns the answers."""
        answers = b""
        for message in self._decoder.feed(data):
            if isinstance(message, Hello):
                answers += self._greet(message)
            elif isinstance(message, CommandMessage):
                self._take(message)
        if self._decoder.other_version is not None:
            # in its own version, so that the other side can report what is wrong
            self._decoder.other_version = None
            answers += self._announcement(0)
        return answers

    def advance(self) -> None:
        """Ends commands and sessions that have outlived their time; to be called before each step of the simulator."""
        now = self._simulator.time
        if self.estop_pressed:
            self._disarm("emergency stop")
        if self._turning and now >= self._expires:
            self._expired = True
            self._halt("life")
        if self._session and now - self._heard > SESSION_TIMEOUT:
            self._session = 0
            self._disarm("session")

    def end(self) -> None:
        """Power off."""
        self._disarm("restart")

    def sense(self, impact: Impact) -> None:
        """Measures an impact, for the telemetry, where the ring has a sensor."""
        if self._senses:
            change_x, change_y = (impact.velocity_after - impact.velocity_before).tolist()
            self._impacts += 1
            self._impact = impact.time, rotate(change_x, change_y, -self._simulator.state.yaw)

    def take_stops(self) -> list[Stop]:
        """The stops since the last call, in order."""
        taken, self._stops = self._stops, []
        return taken

    def telemetry(self) -> bytes:
        """One frame of telemetry."""
        now, decoder, state = self._simulator.time, self._decoder, self._simulator.state
        echo, echo_time = self._echo or (0, now)
        impact_time, impact = self._impact or (-1e9, (0.0, 0.0))
        body = rotate(*state.velocity.tolist(), -state.yaw)
        wheels = self._wheels.speeds(np.array(body), 0.0)
        frame = self._encoder.encode(
            Telemetry(
                session=self._session,
                boot=self._boot,
                time=round(now * 1e3) % CLOCK,
                status=self._status(),
                battery=round(self.battery * 1e3),
                temperature=NO_TEMPERATURE,
                echo=echo,
                echo_delay=_age(now - echo_time),
                command_age=_age(now - self._born) if self._turning else NEVER,
                accepted=decoder.accepted % COUNTS,
                dropped=sum(decoder.dropped.values()) % COUNTS,
                impacts=self._impacts % COUNTS,
                impact_age=_age(now - impact_time),
                impact=impact,
                wheels=tuple(wheels.tolist()),
            )
        )
        self.stalled = False
        return frame

    @property
    def _turning(self) -> bool:
        return bool(self._speeds.any())

    def _status(self) -> int:
        bits = {
            ARMED: self._armed,
            ESTOP_PRESSED: self.estop_pressed,
            BATTERY_LOW: self.battery < LOW_BATTERY,
            EXPIRED: self._expired,
            STALLED: self.stalled,
        }
        return sum(bit for bit, on in bits.items() if on)

    def _announcement(self, session: int) -> bytes:
        capabilities = SENSES_IMPACTS if self._senses else 0
        return self._encoder.encode(
            Announce(session, self._boot, capabilities, self._n_wheels, round(LONGEST_LIFE * 1e3), "emulator 1")
        )

    def _greet(self, hello: Hello) -> bytes:
        self._heard = self._simulator.time
        if hello.session != self._session:
            self._session = hello.session
            self._delay = float("inf")
            self._echo = None
            self._disarm("session")
        return self._announcement(hello.session)

    def _take(self, command: CommandMessage) -> None:
        now = self._simulator.time
        if not self._session or command.session != self._session or len(command.wheels) != self._n_wheels:
            self.refused += 1
            return
        spent = self._time_on_the_way(command.sent, now)
        self._heard = now
        life = min(command.life * 1e-3, LONGEST_LIFE) - spent
        speeds = np.array(command.wheels)
        if command.flags & EMERGENCY_STOP or self.estop_pressed:
            self._disarm("emergency stop")
        elif not speeds.any():
            self._armed = True
            self._halt("command")
        elif not self._armed:
            self.refused += 1
        elif life <= 0.0:
            self.refused += 1
            self.late += 1
        else:
            self._follow(speeds, life, now - command.age * 1e-3 - spent)
        self._echo = command.sent, now

    def _follow(self, speeds: np.ndarray, life: float, born: float) -> None:
        now = self._simulator.time
        self._speeds, self._expires, self._born = speeds, now + life, born
        self._expired = False
        velocity, yaw_rate = self._wheels.twist(speeds)
        self._simulator.command(velocity, yaw_rate)

    def _time_on_the_way(self, sent: int, now: float) -> float:
        """Time that this frame took beyond the fastest one of this session [s]."""
        delay = now - sent * 1e-3
        if isfinite(self._delay):
            self._delay += DRIFT * max(now - self._heard, 0.0)
        self._delay = min(self._delay, delay)
        return delay - self._delay

    def _disarm(self, cause: str) -> None:
        self._armed = False
        self._halt(cause)

    def _halt(self, cause: str) -> None:
        if self._turning:
            now = self._simulator.time
            self._stops.append(Stop(now, now - self._born, cause))
            self._speeds = np.zeros(len(self._wheels))
            self._simulator.command(np.zeros(2), 0.0)


def _age(seconds: float) -> int:
    return min(round(seconds * 1e3), NEVER)
