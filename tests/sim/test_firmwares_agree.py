"""The reference firmware and the emulated one, written apart from the same page, do the same with the same bytes."""

from dataclasses import replace
from random import Random

import numpy as np
import pytest
from c_compiler import NEEDS_COMPILER
from damaged_frames import damaged
from telemetry_example import TELEMETRY

from collplan_core.parameters import Settings
from collplan_core.worlds import World, parse_world
from omnipuck_driver.codec import Decoder, Encoder
from omnipuck_driver.kinematics import OmniWheels
from omnipuck_driver.messages import EXPIRED, NEVER, STALLED, Announce, CommandMessage, Hello, Telemetry, WheelCaps
from omnipuck_sim.emulator.c_firmware import CFirmware
from omnipuck_sim.emulator.firmware import Firmware
from omnipuck_sim.robot.physics import Simulator

pytestmark = NEEDS_COMPILER
HALL = parse_world({"name": "hall", "bounds": [-50.0, -50.0, 50.0, 50.0], "start": [0.0, 0.0]}, "hall")
SETTINGS = Settings().with_values({"simulator.noise": 0.0, "emulator.senses_impacts": True})
STEP = 1.0 / SETTINGS.simulator.physics_rate
SAME = ("session", "boot", "battery", "temperature", "echo", "accepted", "dropped", "cleared", "released")
CLOCK_RESOLUTION = 2e-3
"""The reference firmware's clock counts milliseconds; it is read at each end [s]."""


class CommandedSimulator(Simulator):
    """The simulated robot, and the wheel speeds (n,) last commanded of it [rad/s]."""

    def __init__(self, world: World, settings: Settings, seed: int) -> None:
        self._omni_wheels = OmniWheels(settings.kinematics)
        self.wheels = np.zeros(len(self._omni_wheels))
        super().__init__(world, settings, seed)

    def command(self, velocity_body: np.ndarray, yaw_rate: float, age: float = 0.0) -> None:
        super().command(velocity_body, yaw_rate, age)
        self.wheels = self._omni_wheels.speeds(np.asarray(velocity_body), yaw_rate)


class Side:
    def __init__(self, kind: type) -> None:
        self.simulator = CommandedSimulator(HALL, SETTINGS, 0)
        self.firmware = kind(self.simulator, SETTINGS, boot=7)
        self.decoder = Decoder()
        self.decoder.feed(self.firmware.booted())

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            self.firmware.advance()
            self.simulator.step()

    def hears(self, data: bytes) -> list[Announce]:
        """Its answers, but for its name."""
        said = self.decoder.feed(self.firmware.receive(data))
        return [replace(each, firmware="") for each in said if isinstance(each, Announce)]

    @property
    def told(self) -> Telemetry:
        return next(each for each in self.decoder.feed(self.firmware.telemetry())[::-1] if isinstance(each, Telemetry))


class Host:
    def __init__(self, chance: Random) -> None:
        self.chance = chance
        self.encoder = Encoder()
        self.session = 0
        self.cleared = self.released = 0
        self.ahead = chance.choice([5000, (1 << 32) - 2000])

    def frame(self, now: float) -> bytes:
        chance = self.chance
        if chance.random() < 0.03 or not self.session:
            self.session = chance.choice([self.session or 1, chance.randrange(4)])
            hello = Hello(self.session, WheelCaps(chance.choice([8.0, 60.0]), 512.0))
            return b"".join(self.encoder.encode(hello) for _ in range(chance.choice([1, 1, 2])))
        if chance.random() < 0.02:
            return self.encoder.encode(TELEMETRY)
        self.cleared = (self.cleared + (chance.random() < 0.1)) % 256
        self.released = (self.released + (chance.random() < 0.3)) % 256
        wheels = chance.choice([(0.0,) * 3, (-20.0, 0.0, 20.0), tuple(chance.uniform(-90.0, 90.0) for _ in range(3))])
        if chance.random() < 0.03:
            wheels += (1.0,)
        # one that is a little late, or by what may be a clock; the first of a session is the fastest there is
        late = 6000 if chance.random() < 0.02 else chance.choice([0, 0, 0, 0, 40, 150, 300])
        flags = chance.choice([0] * 40 + [1, 2, 3, 0x80])
        session = self.session if chance.random() < 0.95 else 9
        message = CommandMessage(
            session=session,
            sent=(round(now * 1e3) - late + self.ahead) % (1 << 32),
            age=chance.randrange(100),
            life=chance.choice([0, 80, 200, 700]),
            flags=flags,
            cleared=self.cleared,
            released=self.released,
            wheels=wheels,
        )
        return self.encoder.encode(message)


def differences(sides: list[Side], unsure: int) -> list[str]:
    """In what the firmwares differ, in words; not in the bits `unsure` of their status."""
    both = one, other = [side.told for side in sides]
    found = [name for name in SAME if getattr(one, name) != getattr(other, name)]
    if (one.status ^ other.status) & ~(STALLED | unsure):
        found.append("status")
    for name in ("command_age", "echo_delay"):
        ages = [getattr(each, name) for each in both]
        if (NEVER in ages and ages[0] != ages[1]) or abs(ages[0] - ages[1]) > 1e3 * CLOCK_RESOLUTION:
            found.append(name)
    speeds = [side.simulator.wheels for side in sides]
    if np.abs(speeds[0] - speeds[1]).max() > 512.0 * CLOCK_RESOLUTION:
        found.append(f"speeds {speeds}")
    return [f"{', '.join(found)}: {one}, {other}"] if found else []


def agree(seed: int, n_frames: int) -> int:
    chance = Random(seed)
    host, sides = Host(chance), [Side(Firmware), Side(CFirmware)]
    moved = unsure = 0
    for number in range(n_frames):
        if abs(sides[0].firmware.expires - sides[0].simulator.time) <= 2.0 * CLOCK_RESOLUTION:
            # a fresh command at the end of a life goes on for one, and sets out from rest for the other
            for side in sides:
                side.run(5.0 * CLOCK_RESOLUTION)
        data = host.frame(sides[0].simulator.time)
        if chance.random() < 0.2:
            data = damaged(data, chance)
        if chance.random() < 0.05:
            name, value = chance.choice(["estop_pressed", "motor_fault", "too_hot"]), chance.random() < 0.1
            for side in sides:
                setattr(side.firmware, name, value)
            # of a life that ends at this moment one sees the end first, the other the fault
            unsure = EXPIRED
        pause = chance.choice([0.005, 0.025, 0.045, 0.125]) + (1.2 if chance.random() < 0.02 else 0.0)
        answers = [side.hears(data) for side in sides]
        assert answers[0] == answers[1], f"seed {seed}, frame {number}"
        for side in sides:
            side.run(pause)
        if differences(sides, unsure):
            # a life that ends at this moment ends for one a little earlier
            for side in sides:
                side.run(2.0 * CLOCK_RESOLUTION)
        assert not differences(sides, unsure), f"seed {seed}, frame {number}"
        if sides[0].simulator.wheels.any():
            moved, unsure = moved + 1, 0
    return moved


@pytest.mark.parametrize("seeds", [range(8), pytest.param(range(100, 150), marks=pytest.mark.soak)])
def test_both_do_the_same_with_what_a_line_may_bring(seeds):
    moved = sum(agree(seed, 150) for seed in seeds)
    assert moved > 7 * len(seeds)
