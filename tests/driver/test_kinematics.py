"""Omni wheels: worked by hand, there and back, saturated, and arrangements that cannot move every way."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Cap, Kinematics, Robot, Settings
from collplan_core.parameters.spec import ParameterError
from omnipuck_driver.codec import Encoder
from omnipuck_driver.kinematics import OmniWheels, check_command_rate
from omnipuck_driver.messages import CommandMessage

QUICK = settings(derandomize=True, deadline=None, max_examples=150)
SPEEDS = st.floats(-2.0, 2.0)


@st.composite
def arrangements(draw):
    """Three to eight wheels, each within a fifth of a turn's share of its even place."""
    n, turn = draw(st.integers(3, 8)), draw(st.floats(0.0, 1.0))
    shifts = draw(st.lists(st.floats(-0.2, 0.2), min_size=n, max_size=n))
    angles = tuple(((k + shift) / n * 2 * pi + turn) % (2 * pi) for k, shift in enumerate(shifts))
    radii = draw(st.floats(0.02, 0.5)), draw(st.floats(0.005, 0.1))
    return OmniWheels(Kinematics(angles, *radii))


def test_by_hand():
    wheels = OmniWheels(Kinematics((0.0, pi / 2, pi), mount_radius=0.1, wheel_radius=0.02))
    # wheel 0 is in front and drives to the left, wheel 1 on the left drives back, wheel 2 behind drives to the right
    assert wheels.speeds(np.array([1.0, 0.0]), 0.0) == pytest.approx([0.0, -50.0, 0.0], abs=1e-9)
    assert wheels.speeds(np.array([0.0, 1.0]), 0.0) == pytest.approx([50.0, 0.0, -50.0], abs=1e-9)
    assert wheels.speeds(np.zeros(2), 2.0) == pytest.approx([10.0, 10.0, 10.0])


@given(arrangements(), SPEEDS, SPEEDS, st.floats(-5.0, 5.0))
@QUICK
def test_there_and_back(wheels, x, y, yaw_rate):
    velocity, turn = wheels.twist(wheels.speeds(np.array([x, y]), yaw_rate))
    assert [*velocity, turn] == pytest.approx([x, y, yaw_rate], abs=1e-12, rel=1e-12)


@given(arrangements(), SPEEDS, SPEEDS, st.floats(-5.0, 5.0))
@QUICK
def test_saturation_keeps_the_direction(wheels, x, y, yaw_rate):
    wanted = np.array([x, y, yaw_rate])
    slowed = wheels.saturated(wheels.speeds(wanted[:2], yaw_rate))
    assert np.max(np.abs(slowed)) <= 80.0 * (1 + 1e-12)
    velocity, turn = wheels.twist(slowed)
    share = np.linalg.norm([*velocity, turn]) / max(np.linalg.norm(wanted), 1e-300)
    assert share <= 1.0 + 1e-9
    assert [*velocity, turn] == pytest.approx(share * wanted, abs=1e-9)


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"wheel_angles": (0.0, pi)}, "kinematics.wheel_angles: got 2 angles, expected 3 to 8"),
        ({"wheel_angles": (0.0, pi, 0.0, pi)}, "parallel"),
        ({"wheel_angles": (0.0, 0.01, pi)}, "parallel"),
        ({"wheel_radius": 0.0}, "kinematics.wheel_radius: got 0.0"),
    ],
)
def test_wheels_that_cannot_move_every_way_are_refused(values, named):
    with pytest.raises(ParameterError, match=named):
        OmniWheels(Kinematics(**values))


@QUICK
@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.sampled_from(("disc", "box")))
def test_a_robot_within_its_own_caps_asks_no_wheel_for_more_than_the_firmware_lets_through(x, y, turn, shape):
    robot, cap = Robot(velocity_shape=shape), Cap()
    wheels = OmniWheels(Kinematics())
    velocity = cap.speed * np.array([x, y]) / (max(np.hypot(x, y), 1.0) if shape == "disc" else 1.0)
    speeds = wheels.speeds(velocity, turn * robot.max_yaw_rate)
    assert np.abs(wheels.saturated(speeds)).max() <= wheels.caps(cap, robot).speed * (1 + 1e-6)


# ---- how often commands must and can be sent: refused at the start, not found out while driving

DRIVER, LIMITS = Settings().driver, Settings().limits


def refusal(rate: float, baud: int = 115200, age: float = 0.2, n_wheels: int = 3) -> str:
    try:
        check_command_rate(replace(DRIVER, rate=rate, baud=baud), replace(LIMITS, command_age=age), n_wheels)
    except ParameterError as error:
        return str(error)
    return ""


def test_what_is_shipped_can_be_sent_and_what_cannot_is_refused():
    for asked, words in (
        ((DRIVER.rate, DRIVER.baud, LIMITS.command_age), ""),
        ((5.0,), "got 5, expected at least 2 / limits.command_age = 10 Hz"),
        ((50.0, 9600), "got 50, expected at most 24 Hz"),
        ((24.0, 9600), ""),
    ):
        assert words in refusal(*asked)
        assert bool(words) == bool(refusal(*asked))


@QUICK
@given(st.floats(5.0, 200.0), st.sampled_from([9600, 19200, 57600, 115200]), st.integers(3, 8), st.floats(-80.0, 80.0))
def test_what_is_not_refused_fits_the_line_whatever_is_commanded(rate, baud, n_wheels, speed):
    frame = Encoder().encode(CommandMessage(42, 1000, 20, 180, 0, 3, 7, (speed,) * n_wheels))
    assert (refusal(rate, baud, age=0.5, n_wheels=n_wheels) == "") == (10 * len(frame) * rate <= baud)
