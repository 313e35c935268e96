"""Both firmwares without a port: who they are, and for what cause they stopped.

The rules of the protocol are held by the reference firmware's own tests, and test_firmwares_agree compares the two.
"""

from math import pi

import numpy as np
import pytest
from c_compiler import NEEDS_COMPILER
from hypothesis import strategies as st

from collplan_core.parameters import EmulatorFaults, Settings
from collplan_core.parameters.spec import ParameterError
from collplan_core.worlds import parse_world
from firmware_bench import CommandedSimulator
from omnipuck_driver.codec import Decoder, Encoder
from omnipuck_driver.messages import (
    ARMED,
    ESTOP_PRESSED,
    EXPIRED,
    HOLD,
    NEVER,
    SENSES_IMPACTS,
    Announce,
    CommandMessage,
    Hello,
    Telemetry,
    WheelCaps,
)
from omnipuck_sim.emulator.c_firmware import CFirmware
from omnipuck_sim.emulator.faults import BadLine
from omnipuck_sim.emulator.firmware import MOST_ACCELERATION, Firmware

HALL = parse_world({"name": "hall", "bounds": [-1.0, -1.0, 9.0, 1.0], "start": [0.0, 0.0]}, "hall")
FORWARD = (-20.0, 0.0, 20.0)
REST = (0.0, 0.0, 0.0)
CAPS = WheelCaps(60.0, 512.0)
WHEEL = st.floats(width=32, allow_nan=False, allow_infinity=False)
OWN_CAPS = WheelCaps(Settings().kinematics.max_wheel_speed, MOST_ACCELERATION)
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
        self.say(Hello(42, CAPS))
        self.command(REST)
        self.release()
        return self

    @property
    def is_armed(self) -> bool:
        return bool(self.telemetry.status & ARMED)

    @property
    def telemetry(self) -> Telemetry:
        self.heard(self.firmware.telemetry())
        return self.told[-1]

    @property
    def turning(self) -> bool:
        return self.telemetry.command_age != NEVER


def test_hello_is_answered_once_with_what_it_is_and_ends_a_session_where_it_names_none():
    device = Device()
    announced = [Announce(42, 7, 0, 3, 500, CAPS, Device.name)]
    assert device.say(Hello(41, CAPS), Hello(42, CAPS), Hello(42, CAPS)) == announced
    for _ in range(2):
        assert device.say(Hello(42, CAPS)) == announced
        assert device.say(Hello(0, CAPS)) == [Announce(0, 7, 0, 3, 500, OWN_CAPS, Device.name)]
        assert device.telemetry.session == 0
        assert (device.telemetry.echo, device.telemetry.echo_delay) == (0, NEVER)
    # its own caps hold where larger ones are asked for
    assert device.say(Hello(43, WheelCaps(1e6, 1e6)))[0].caps == OWN_CAPS
    assert Device(senses_impacts=True).say(Hello(1, CAPS))[0].capabilities == SENSES_IMPACTS


def test_what_it_cannot_pretend_is_refused():
    if Device.kind is Firmware:
        assert Device(faults="n_wheels=4").say(Hello(1, CAPS))[0].n_wheels == 4
        return
    for wrong in ("n_wheels=4", "protocol_version=3"):
        with pytest.raises(ParameterError, match=rf"^emulator\.faults: got {wrong}, expected"):
            Device(faults=wrong)


def test_a_command_ends_with_its_life_by_the_clock_of_the_device():
    device = Device().armed()
    device.command(FORWARD, life=0.15, age=50)
    assert not device.telemetry.status & EXPIRED
    device.run(0.3)
    (stop,) = device.firmware.take_stops()
    assert (stop.time, stop.cause) == (pytest.approx(0.15), "life")
    assert stop.age == pytest.approx(0.2, abs=Device.resolution or 2e-7)
    # a fresh command before the next telemetry does not hide it
    device.command(FORWARD)
    assert device.turning
    assert any(telemetry.status & EXPIRED for telemetry in device.told)
    assert not device.telemetry.status & EXPIRED
    device.command(FORWARD, life=60.0)
    device.run(1.0)
    assert device.firmware.take_stops()[0].time == pytest.approx(0.3 + 0.5, abs=2 * Device.resolution + 1e-6)


def test_a_new_session_a_host_that_holds_it_and_silence_stop_and_disarm():
    device = Device().armed()
    device.command(FORWARD)
    device.run(0.01)
    device.command(FORWARD, flags=HOLD)
    assert device.firmware.take_stops()[0].cause == "hold"
    device.command(FORWARD)
    assert not device.turning
    device.release()
    device.command(FORWARD)
    assert device.turning
    device.run(0.01)
    device.say(Hello(43, CAPS))
    assert device.firmware.take_stops()[0].cause == "session"
    assert not device.is_armed
    device.command(REST, session=43)
    device.run(1.1)
    assert (device.telemetry.session, device.is_armed) == (0, False)


def test_a_pressed_button_stops_it():
    device = Device().armed()
    device.command(FORWARD)
    device.run(0.01)
    device.firmware.estop_pressed = True
    device.run(0.01)
    assert device.firmware.take_stops()[0].cause == "emergency stop"
    assert device.telemetry.status & ESTOP_PRESSED


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
