"""The firmware's end of the protocol around the simulated robot, without a port. Its clock is the simulator's."""

from dataclasses import dataclass

import numpy as np

from collplan_core.ages import STEP, SmallestDelay
from collplan_core.impact import Impact
from collplan_core.parameters import Settings
from collplan_core.plane import rotate
from omnipuck_driver.codec import Decoder, Encoder
from omnipuck_driver.kinematics import OmniWheels
from omnipuck_driver.messages import (
    ARMED,
    BATTERY_LOW,
    EMERGENCY_STOP,
    ESTOP_LATCHED,
    ESTOP_PRESSED,
    EXPIRED,
    HOLD,
    MOTOR_FAULT,
    NEVER,
    NO_TEMPERATURE,
    SENSES_IMPACTS,
    STALLED,
    TO_DEVICE,
    TOO_HOT,
    Announce,
    CommandMessage,
    Hello,
    Telemetry,
    WheelCaps,
)
from omnipuck_sim.robot.physics import Simulator

LONGEST_LIFE = 0.5
"""Longest life of a command, whatever it requests [s]."""
SESSION_TIMEOUT = 1.0
"""Silence after which a session is over [s]."""
LOW_BATTERY = 6.6
"""Voltage below which the battery is reported as low [V]."""
MOST_ACCELERATION = 1024.0
"""Its own cap of a wheel's acceleration [rad/s^2]; that of the speed is kinematics.max_wheel_speed."""
COUNTS = 1 << 16
CLOCK = 1 << 32


@dataclass(frozen=True)
class Stop:
    """The wheels were set to zero after they had turned."""

    time: float  # of the stop [s]
    age: float  # of the last command followed, since the driver took it [s]
    cause: str  # command, life, hold, clock, emergency stop, motor fault, too hot, session or restart


def measured_wheels(wheels: OmniWheels, simulator: Simulator) -> np.ndarray:
    """Wheel speeds (n,) [rad/s] with which the robot moves."""
    state = simulator.state
    return wheels.speeds(np.array(rotate(*state.velocity.tolist(), -state.yaw)), 0.0)


def change_in_body(impact: Impact, simulator: Simulator) -> tuple[float, float]:
    """Change of velocity in an impact just now, in the body frame [m/s]."""
    change_x, change_y = (impact.velocity_after - impact.velocity_before).tolist()
    return rotate(change_x, change_y, -simulator.state.yaw)


class Firmware:
    """The firmware: takes and gives bytes, and drives the wheels of `simulator`."""

    def __init__(self, simulator: Simulator, settings: Settings, boot: int) -> None:
        faults = settings.emulator.asked
        self.estop_pressed = faults.estop_pressed  # the button on the robot
        self.battery = faults.battery  # its voltage [V]
        self.motor_fault, self.too_hot = faults.motor_fault, faults.too_hot  # a motor has failed, or they are too hot
        self.stalled = False  # held up since the last telemetry
        self.refused = 0  # complete commands that were not followed
        self.late = 0  # refused ones that expired on the way
        self._simulator = simulator
        self._wheels = OmniWheels(settings.kinematics)
        self._n_wheels = faults.n_wheels or len(self._wheels)
        self._senses = settings.emulator.senses_impacts
        self._boot = boot
        version = faults.protocol_version
        self._encoder, self._decoder = Encoder(version), Decoder(version, TO_DEVICE)
        self._session = 0
        self._own_caps = WheelCaps(float(np.float32(settings.kinematics.max_wheel_speed)), MOST_ACCELERATION)
        self._caps = self._own_caps
        self._acts: tuple[int, int] | None = None
        self._armed = False
        self._latched = False
        self._expired = False
        self._noticed = 0
        self._heard = 0.0
        self._delay = SmallestDelay()
        self._sent = 0
        self._echo: tuple[int, float] | None = None
        self._asked = np.zeros(len(self._wheels))
        self._speeds = np.zeros(len(self._wheels))
        self._advanced = 0.0
        self.expires = 0.0  # when the last followed command ends, by the simulator's clock [s]
        self._born = 0.0
        self._impacts = 0
        self._impact: tuple[float, tuple[float, float]] | None = None
        self._stops: list[Stop] = []

    def booted(self) -> bytes:
        """The announcement after a start."""
        return self._announcement(0)

    def receive(self, data: bytes) -> bytes:
        """Takes bytes; returns the answers: several Hellos received at once get one."""
        greeted = False
        for message in self._decoder.feed(data):
            if isinstance(message, Hello):
                self._greet(message)
                greeted = True
            elif isinstance(message, CommandMessage):
                self._take(message)
        answers = b""
        if self._decoder.other_version is not None:
            # in its own version, so that the other side can report what is wrong
            self._decoder.other_version = None
            answers += self._announcement(0)
        return answers + (self._announcement(self._session) if greeted else b"")

    def advance(self) -> None:
        """Ends commands and sessions that have outlived their time; to be called before each step of the simulator."""
        now = self._simulator.time
        self._noticed |= self._inputs
        if self.estop_pressed:
            self._latched = True
            self._disarm("emergency stop")
        if self._fault:
            self._disarm(self._fault)
        self._turn(now - self._advanced)
        self._advanced = now
        if self._turning and now >= self.expires:
            self._expired = True
            self._noticed |= EXPIRED
            self._halt("life")
        if self._session and now - self._heard > SESSION_TIMEOUT:
            self._begin(0, self._own_caps)

    def end(self) -> None:
        """Switches the firmware off."""
        self._disarm("restart")

    def sense(self, impact: Impact) -> None:
        """Measures an impact, for the telemetry, where the ring has a sensor."""
        if self._senses:
            self._impacts += 1
            self._impact = impact.time, change_in_body(impact, self._simulator)

    def take_stops(self) -> list[Stop]:
        """The stops since the last call, in order."""
        taken, self._stops = self._stops, []
        return taken

    def counts(self) -> dict[str, int]:
        """Commands that were refused, and those of them that came too late."""
        return {"refused": self.refused, "late": self.late}

    def telemetry(self) -> bytes:
        """One frame of telemetry."""
        now, decoder = self._simulator.time, self._decoder
        echo, echo_time = self._echo or (0, -1e9)
        impact_time, impact = self._impact or (-1e9, (0.0, 0.0))
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
                cleared=self._acts[0] if self._acts else 0,
                released=self._acts[1] if self._acts else 0,
                wheels=tuple(measured_wheels(self._wheels, self._simulator).tolist()),
            )
        )
        self.stalled = False
        self._noticed = 0
        return frame

    @property
    def _turning(self) -> bool:
        return bool(self._asked.any())

    @property
    def _fault(self) -> str:
        if self.motor_fault:
            return "motor fault"
        return "too hot" if self.too_hot else ""

    @property
    def _inputs(self) -> int:
        """Returns the present status bits of the inputs."""
        return _bits({ESTOP_PRESSED: self.estop_pressed, MOTOR_FAULT: self.motor_fault, TOO_HOT: self.too_hot})

    def _status(self) -> int:
        bits = {
            ARMED: self._armed,
            BATTERY_LOW: self.battery < LOW_BATTERY,
            EXPIRED: self._expired,
            STALLED: self.stalled,
            ESTOP_LATCHED: self._latched,
        }
        return self._noticed | self._inputs | _bits(bits)

    def _announcement(self, session: int) -> bytes:
        capabilities = SENSES_IMPACTS if self._senses else 0
        life = round(LONGEST_LIFE * 1e3)
        return self._encoder.encode(
            Announce(session, self._boot, capabilities, self._n_wheels, life, self._caps, "emulator 2")
        )

    def _greet(self, hello: Hello) -> None:
        self._heard = self._simulator.time
        if hello.session != self._session:
            # 0 begins none: its caps are not announced
            self._begin(hello.session, hello.caps.within(self._own_caps) if hello.session else self._own_caps)

    def _begin(self, session: int, caps: WheelCaps) -> None:
        """A session, 0 for none."""
        self._session, self._caps = session, caps
        self._delay = SmallestDelay()
        self._acts = None
        self._echo = None
        self._disarm("session")

    def _take(self, command: CommandMessage) -> None:
        now = self._simulator.time
        if not self._session or command.session != self._session or len(command.wheels) != self._n_wheels:
            self.refused += 1
            return
        self._heard = now
        stop = bool(command.flags & EMERGENCY_STOP) or self.estop_pressed
        spent = self._time_on_the_way(command.sent, now)
        life = min(command.life * 1e-3, LONGEST_LIFE) - spent
        if spent > STEP:
            # it may have been held up for as long, so that the commands waiting behind this one are as old
            self._disarm("clock")
        if stop:
            self._latched = True
            self._disarm("emergency stop")
        if command.flags & HOLD:
            self._disarm("hold")
        if life <= 0.0:
            self.refused += 1
            self.late += 1
            return
        self._take_acts((command.cleared, command.released), stop, bool(command.flags & HOLD))
        self._echo = command.sent, now
        speeds = np.array(command.wheels)
        if not speeds.any():
            self._halt("command")
        elif self._armed:
            self._follow(speeds, now + life, now - command.age * 1e-3 - spent)
        else:
            self.refused += 1

    def _take_acts(self, acts: tuple[int, int], stop: bool, hold: bool) -> None:
        """Takes a person's actions since the previous command of this session; none are known at the first."""
        (cleared, released), (cleared_before, released_before) = acts, self._acts or acts
        self._acts = acts
        if cleared != cleared_before and not stop:
            self._latched = False
        if released != released_before and not (hold or self._latched or self._fault):
            self._armed = True

    def _follow(self, speeds: np.ndarray, expires: float, born: float) -> None:
        peak = float(np.max(np.abs(speeds)))
        self._asked = speeds * min(self._caps.speed / peak, 1.0)
        self.expires, self._born = expires, born
        self._expired = False
        self._drive()

    def _turn(self, duration: float) -> None:
        """Brings the wheels nearer to the commanded speeds: slower at once, faster by the cap of acceleration."""
        if not self._turning or np.array_equal(self._speeds, self._asked):
            return
        same_way = np.sign(self._speeds) == np.sign(self._asked)
        slowed = np.where(same_way, np.sign(self._asked) * np.minimum(np.abs(self._speeds), np.abs(self._asked)), 0.0)
        missing = self._asked - slowed
        largest = float(np.max(np.abs(missing)))
        # all alike, so that the direction is kept
        share = min(self._caps.acceleration * duration / largest, 1.0) if largest else 1.0
        self._speeds = slowed + share * missing
        self._drive()

    def _drive(self) -> None:
        velocity, yaw_rate = self._wheels.twist(self._speeds)
        self._simulator.command(velocity, yaw_rate)

    def _time_on_the_way(self, sent: int, now: float) -> float:
        """Time that this frame took beyond the fastest one of this session [s]."""
        # numbers near each other differ by less than half of what the clock counts to
        self._sent += (sent - self._sent + CLOCK // 2) % CLOCK - CLOCK // 2
        self._delay, spent = self._delay.measured(self._sent * 1e-3, now)
        return spent

    def _disarm(self, cause: str) -> None:
        self._armed = False
        self._halt(cause)

    def _halt(self, cause: str) -> None:
        if self._turning:
            now = self._simulator.time
            self._stops.append(Stop(now, now - self._born, cause))
            self._asked = np.zeros(len(self._wheels))
            self._speeds = np.zeros(len(self._wheels))
            self._simulator.command(np.zeros(2), 0.0)


def _bits(status: dict[int, bool]) -> int:
    return sum(bit for bit, on in status.items() if on)


def _age(seconds: float) -> int:
    return min(round(seconds * 1e3), NEVER)
