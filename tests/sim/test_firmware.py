"""The emulated firmware without a port: when it follows commands, and that it stops by itself."""

from math import pi

import numpy as np
import pytest

from collplan_core.parameters import Emulator, Settings
from collplan_core.worlds import parse_world
from omnipuck_driver.codec import Decoder, Encoder
from omnipuck_driver.messages import (
    ARMED,
    EMERGENCY_STOP,
    ESTOP_PRESSED,
    EXPIRED,
    NEVER,
    SENSES_IMPACTS,
    Announce,
    CommandMessage,
    Hello,
    Telemetry,
)
from omnipuck_sim.emulator.faults import BadLine
from omnipuck_sim.emulator.firmware import Firmware
from omnipuck_sim.robot.physics import Simulator

HALL = parse_world({"name": "hall", "bounds": [-1.0, -1.0, 9.0, 1.0], "start": [0.0, 0.0]}, "hall")
FORWARD = (-20.0, 0.0, 20.0)
REST = (0.0, 0.0, 0.0)


class Device:
    """A firmware, and a host that says what the test wants."""

    def __init__(self, **emulator) -> None:
        values = {"simulator.noise": 0.0, **{f"emulator.{name}": value for name, value in emulator.items()}}
        settings = Settings().with_values(values)
        self.simulator = Simulator(HALL, settings, 0)
        self.firmware = Firmware(self.simulator, settings, boot=7)
        self.encoder, self.decoder = Encoder(), Decoder()

    def say(self, message) -> list:
        return self.decoder.feed(self.firmware.receive(self.encoder.encode(message)))

    def command(self, wheels, life=0.2, session=42, flags=0, late=0.0, age=0) -> None:
        sent = round((self.simulator.time - late) * 1e3) + 5000
        self.say(CommandMessage(session, sent, age, round(life * 1e3), flags, wheels))

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * Settings().simulator.physics_rate)):
            self.firmware.advance()
            self.simulator.step()
            for impact in self.simulator.take_impacts():
                self.firmware.sense(impact)

    def armed(self) -> "Device":
        self.say(Hello(42))
        self.command(REST)
        return self

    @property
    def telemetry(self) -> Telemetry:
        return self.decoder.feed(self.firmware.telemetry())[0]

    @property
    def turning(self) -> bool:
        return self.telemetry.command_age != NEVER


def test_hello_is_answered_with_what_it_is():
    assert Device().say(Hello(42)) == [Announce(42, 7, 0, 3, 500, "emulator 1")]
    assert Device(senses_impacts=True, n_wheels=4).say(Hello(1))[0].capabilities == SENSES_IMPACTS


def test_nothing_but_zero_is_followed_before_zero_was():
    device = Device()
    device.command(FORWARD)
    device.say(Hello(42))
    device.command(FORWARD)
    assert not device.turning
    device.command(REST, session=41)
    assert not device.telemetry.status & ARMED
    device.command(REST)
    assert device.telemetry.status & ARMED
    device.command(FORWARD)
    assert device.turning
    assert device.firmware.refused == 3


def test_a_command_ends_with_its_life_by_the_clock_of_the_device():
    device = Device().armed()
    device.command(FORWARD, life=0.15, age=50)
    device.run(0.3)
    (stop,) = device.firmware.take_stops()
    assert (stop.time, stop.age, stop.cause) == (pytest.approx(0.15), pytest.approx(0.2), "life")
    assert device.telemetry.status & EXPIRED
    device.command(FORWARD)
    assert device.turning


def test_no_life_is_longer_than_its_own_limit():
    device = Device().armed()
    device.command(FORWARD, life=60.0)
    device.run(1.0)
    assert device.firmware.take_stops()[0].time == pytest.approx(0.5)


def test_time_on_the_way_is_taken_off_the_life():
    device = Device().armed()
    device.run(1.0)
    device.command(REST)
    device.command(FORWARD, life=0.2, late=0.15)
    device.run(0.3)
    assert device.firmware.take_stops()[0].age == pytest.approx(0.2, abs=0.005)
    device.command(FORWARD, life=0.2, late=0.25)
    assert not device.turning
    assert device.firmware.late == 1


def test_a_new_session_stops_and_disarms_and_so_does_silence():
    device = Device().armed()
    device.command(FORWARD)
    device.say(Hello(43))
    assert device.firmware.take_stops()[0].cause == "session"
    assert not device.telemetry.status & ARMED
    device.command(REST, session=43)
    device.run(1.1)
    assert (device.telemetry.session, device.telemetry.status & ARMED) == (0, 0)


def test_the_same_hello_again_changes_nothing():
    device = Device().armed()
    device.command(FORWARD)
    device.say(Hello(42))
    assert device.turning


@pytest.mark.parametrize("how", ["flag", "button"])
def test_an_emergency_stop_stops_and_disarms(how):
    device = Device().armed()
    device.command(FORWARD)
    if how == "flag":
        device.command(FORWARD, flags=EMERGENCY_STOP)
    else:
        device.firmware.estop_pressed = True
        device.run(0.01)
        assert device.telemetry.status & ESTOP_PRESSED
        device.command(REST)
        device.firmware.estop_pressed = False
    assert device.firmware.take_stops()[0].cause == "emergency stop"
    device.command(FORWARD)
    assert not device.turning
    device.command(REST)
    device.command(FORWARD)
    assert device.turning


def test_it_drives_where_the_wheels_say():
    device = Device().armed()
    for _ in range(20):
        device.command(FORWARD)
        device.run(0.05)
    speed = 20.0 * 0.02 / np.sin(pi / 3)
    assert device.simulator.state.velocity == pytest.approx([speed, 0.0], abs=1e-3)
    assert device.telemetry.wheels == pytest.approx(FORWARD, abs=0.1)


def test_a_ring_that_senses_tells_the_change_of_velocity_in_the_body_frame():
    device = Device(senses_impacts=True).armed()
    device.simulator.place(np.array([-0.85, 0.0]), np.array([-0.5, 0.0]), yaw=pi / 2)
    device.simulator.drive = False
    device.run(0.5)
    told = device.telemetry
    assert told.impacts == 1
    assert told.impact == pytest.approx((0.0, -0.85), abs=0.01)


def test_another_version_is_answered_in_its_own():
    device = Device(protocol_version=3)
    assert device.say(Hello(42)) == []
    assert device.decoder.other_version == 3
    assert device.firmware.telemetry()


def test_wheels_of_another_number_are_not_followed():
    device = Device().armed()
    device.command((1.0, 2.0, 3.0, 4.0))
    assert not device.turning


def test_a_good_line_changes_nothing_and_a_bad_one_does_what_it_was_asked():
    data = b"\0abcdefgh\0\0ijklmnop\0"
    assert BadLine(0).passed(data, Emulator()) == data
    assert BadLine(0).passed(data, Emulator(lost=1.0)) == b"\0\0\0\0"
    assert BadLine(0).passed(data, Emulator(doubled=1.0)) == b"\0abcdefgh\0abcdefgh\0\0ijklmnop\0ijklmnop\0"
    assert len(BadLine(0).passed(data, Emulator(cut=1.0))) < len(data)
    line = BadLine(0)
    assert line.passed(data, Emulator(split=1.0)) + line.passed(b"", Emulator()) == data
    noisy = BadLine(0).passed(data, Emulator(noise=1.0)).split(b"\0")
    assert noisy[2:3] == [b"abcdefgh"] or b"abcdefgh" in noisy
    flipped = BadLine(0).passed(bytes(8000), Emulator(flipped=0.25))
    assert sum(bin(byte).count("1") for byte in flipped) == pytest.approx(2000, rel=0.1)
