"""Both firmwares without a port: who they are, and for what cause they stopped.

The rules of the protocol are held by the reference firmware's own tests, and test_firmwares_agree compares the two.
"""

from math import pi

import numpy as np
import pytest
from c_compiler import NEEDS_COMPILER

from collplan_core.parameters import EmulatorFaults, Settings
from collplan_core.parameters.spec import ParameterError
from collplan_core.worlds import parse_world
from firmware_bench import CommandedSimulator
from omnipuck_driver.codec import Decoder, Encoder
from omnipuck_driver.messages import (
    HOLD,
    SENSES_IMPACTS,
    Announce,
    CommandMessage,
    Hello,
    Telemetry,
    WheelCaps,
)
from omnipuck_sim.emulator.c_firmware import CFirmware
from omnipuck_sim.emulator.faults import BadLine
from omnipuck_sim.emulator.firmware import Firmware

HALL = parse_world({"name": "hall", "bounds": [-1.0, -1.0, 9.0, 1.0], "start": [0.0, 0.0]}, "hall")
FORWARD = (-20.0, 0.0, 20.0)
REST = (0.0, 0.0, 0.0)
CAPS = WheelCaps(60.0, 512.0)
FIRMWARES = {"emulated": (Firmware, "emulator 2", 0.0), "reference in C": (CFirmware, "reference 2", 1e-3)}


@pytest.fixture(
    scope="module", autouse=True, params=["emulated", pytest.param("reference in C", marks=NEEDS_COMPILER)], ids=str
)
def firmware_kind(request):
    Device.kind, Device.name, Device.resolution = FIRMWARES[request.param]
    return request.param


class Device:
    """A firmware, and a host that says what the test wants.

    Attributes:
        kind, name: of the firmware.
        resolution: of its clock [s].
        told: all its telemetry.
    """

    kind: type = Firmware
    name = ""
    resolution = 0.0

    def __init__(self, **emulator) -> None:
        values = {"simulator.noise": 0.0, **{f"emulator.{name}": value for name, value in emulator.items()}}
        used = Settings().with_values(values)
        self.simulator = CommandedSimulator(HALL, used, 0)
        self.firmware = self.kind(self.simulator, used, boot=7)
        self.encoder, self.decoder = Encoder(), Decoder()
        self.told: list[Telemetry] = []
        self.senses = SENSES_IMPACTS if emulator.get("senses_impacts") else 0
        self.heard(self.firmware.booted())
        self.released = 0

    def heard(self, data: bytes) -> list:
        """What it has said, its telemetry aside."""
        said = self.decoder.feed(data)
        self.told += [each for each in said if isinstance(each, Telemetry)]
        return [each for each in said if not isinstance(each, Telemetry)]

    def say(self, *messages) -> list:
        """Its answers to messages that come at once."""
        return self.heard(self.firmware.receive(b"".join(map(self.encoder.encode, messages))))

    def command(self, wheels, life=0.2, session=42, flags=0, age=0) -> None:
        sent = round(self.simulator.time * 1e3) + 5000
        self.say(CommandMessage(session, sent, age, round(life * 1e3), flags, 0, self.released, wheels))

    def release(self) -> None:
        self.released += 1
        self.command(REST)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * Settings().simulator.physics_rate)):
            self.firmware.advance()
            self.simulator.step()
            for impact in self.simulator.take_impacts():
                self.firmware.sense(impact)

    def armed(self) -> "Device":
        assert self.say(Hello(42, CAPS)) == [Announce(42, 7, self.senses, 3, 500, CAPS, self.name)]
        self.command(REST)
        self.release()
        return self

    @property
    def telemetry(self) -> Telemetry:
        self.heard(self.firmware.telemetry())
        return self.told[-1]


def test_each_stop_is_told_with_its_cause_and_a_life_by_the_clock_of_the_device():
    device, causes = Device().armed(), []

    def pressed():
        device.firmware.estop_pressed = True

    for stop in (
        lambda: device.command(FORWARD, flags=HOLD),
        lambda: (device.say(Hello(43, CAPS)), device.say(Hello(42, CAPS)), device.command(REST), device.release()),
        pressed,
    ):
        device.release()
        device.command(FORWARD)
        device.run(0.01)
        stop()
        device.run(0.01)
        causes += [each.cause for each in device.firmware.take_stops()]
    assert causes == ["hold", "session", "emergency stop"]
    device = Device().armed()
    device.command(FORWARD, life=0.15, age=50)
    device.run(0.3)
    (stop,) = device.firmware.take_stops()
    assert (stop.time, stop.cause) == (pytest.approx(0.15), "life")
    assert stop.age == pytest.approx(0.2, abs=Device.resolution or 2e-7)


def test_what_it_cannot_pretend_is_refused():
    if Device.kind is Firmware:
        assert Device(faults="n_wheels=4").say(Hello(1, CAPS))[0].n_wheels == 4
        return
    for wrong in ("n_wheels=4", "protocol_version=3"):
        with pytest.raises(ParameterError, match=rf"^emulator\.faults: got {wrong}, expected"):
            Device(faults=wrong)


def test_a_ring_that_senses_measures_the_change_of_velocity_in_the_body_frame():
    device = Device(senses_impacts=True).armed()
    device.simulator.place(np.array([-0.85, 0.0]), np.array([-0.5, 0.0]), yaw=pi / 2)
    device.simulator.drive = False
    device.run(0.5)
    measured = device.telemetry
    assert measured.impacts == 1
    assert measured.impact == pytest.approx((0.0, -0.85), abs=0.01)


def test_a_good_line_changes_nothing_and_a_bad_one_does_what_it_was_asked():
    data = b"\0abcdefgh\0\0ijklmnop\0"
    assert BadLine(0).passed(data, EmulatorFaults()) == data
    assert BadLine(0).passed(data, EmulatorFaults(lost=1.0)) == b"\0\0\0\0"
    assert BadLine(0).passed(data, EmulatorFaults(doubled=1.0)) == b"\0abcdefgh\0abcdefgh\0\0ijklmnop\0ijklmnop\0"
    assert len(BadLine(0).passed(data, EmulatorFaults(cut=1.0))) < len(data)
    line = BadLine(0)
    assert line.passed(data, EmulatorFaults(split=1.0)) + line.passed(b"", EmulatorFaults()) == data
    noisy = BadLine(0).passed(data, EmulatorFaults(noise=1.0)).split(b"\0")
    assert noisy[2:3] == [b"abcdefgh"] or b"abcdefgh" in noisy
    flipped = BadLine(0).passed(bytes(8000), EmulatorFaults(flipped=0.25))
    assert sum(bin(byte).count("1") for byte in flipped) == pytest.approx(2000, rel=0.1)


def test_a_text_of_faults_is_read_or_refused_by_name():
    expected = EmulatorFaults(lost=0.1, unplugged=True, restarts=3)
    assert EmulatorFaults.read("lost=0.1, unplugged ,restarts=3") == expected
    for wrong in ("lost=2", "lots=1", "unplugged=3", "lost=[1", "lost"):
        with pytest.raises(ParameterError, match=r"emulator\.faults.*expected"):
            EmulatorFaults.read(wrong)
