"""A person's command: whether it has the robot, why it must not drive, and what of it is sent."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.command import HAND, STOPPED, Command
from collplan_core.control.hand import Hand, hand_command, has_robot, why_not_by_hand
from collplan_core.control.tracking import saturate
from collplan_core.parameters import Limits, Settings

QUICK = settings(derandomize=True, deadline=None, max_examples=60)
SETTINGS = Settings()
ROBOT, LIMITS, PERIOD = SETTINGS.robot, SETTINGS.limits, 1.0 / SETTINGS.controller.rate
FENCED = Limits(fence=(0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0))
speeds = st.floats(-ROBOT.max_speed, ROBOT.max_speed)
velocities = st.tuples(speeds, speeds).map(lambda pair: saturate(np.array(pair), ROBOT.max_speed))
rates = st.floats(-ROBOT.max_yaw_rate, ROBOT.max_yaw_rate)


def hand(x=0.0, y=0.0, yaw_rate=0.0, trouble="") -> Hand:
    return Hand(np.array([x, y]), yaw_rate, 1.0, trouble)


def sent(velocity, yaw_rate=0.0) -> Command:
    return Command(np.array(velocity), yaw_rate, HAND, np.full(2, np.nan))


@QUICK
@given(velocities, rates, velocities, rates, st.booleans())
def test_a_command_goes_from_the_one_before_as_wheels_can_or_to_rest(before, turning, wanted, turn, is_blind):
    command = hand_command(Hand(wanted, turn, 0.0), sent(before, turning), is_blind, SETTINGS)
    if command.velocity.any() and not is_blind:
        assert math.hypot(*(command.velocity - before)) <= ROBOT.max_acceleration * PERIOD + 1e-9
    if command.yaw_rate:
        assert abs(command.yaw_rate - turning) <= ROBOT.max_acceleration / ROBOT.radius * PERIOD + 1e-9


@QUICK
@given(velocities, rates, velocities, rates, st.booleans())
def test_no_command_is_beyond_the_robots_limits(before, turning, wanted, turn, is_blind):
    command = hand_command(Hand(wanted, turn, 0.0), sent(before, turning), is_blind, SETTINGS)
    most = min(LIMITS.blind_speed, ROBOT.max_speed) if is_blind else ROBOT.max_speed
    assert math.hypot(*command.velocity) <= most + 1e-9
    assert abs(command.yaw_rate) <= ROBOT.max_yaw_rate + 1e-9


@QUICK
@given(velocities, rates)
def test_rest_is_at_once(before, turning):
    command = hand_command(hand(), sent(before, turning), False, SETTINGS)
    assert not command.velocity.any()
    assert command.yaw_rate == 0.0


@QUICK
@given(velocities, velocities, rates)
def test_what_is_held_is_reached(before, wanted, turn):
    command = sent(before)
    for _ in range(200):
        command = hand_command(Hand(wanted, turn, 0.0), command, False, SETTINGS)
    assert command.velocity == pytest.approx(wanted, abs=1e-9)
    assert command.yaw_rate == pytest.approx(turn)


def test_by_hand_a_turn_to_the_side_at_speed():
    command = hand_command(hand(0.0, 0.3), sent([1.0, 0.0]), False, SETTINGS)
    change = np.array([-1.0, 0.3]) / math.hypot(1.0, 0.3) * 0.075
    assert command.velocity == pytest.approx(np.array([1.0, 0.0]) + change)


@pytest.mark.parametrize("broken", [hand(math.nan), hand(0.1, math.inf), hand(0.1, yaw_rate=math.nan)])
def test_what_is_no_command_stands(broken):
    command = hand_command(broken, sent([0.3, 0.0]), False, SETTINGS)
    assert (command.maneuver, command.velocity.tolist(), command.yaw_rate) == (STOPPED, [0.0, 0.0], 0.0)
    assert command.reason.startswith("by hand: got ")


@QUICK
@given(st.floats(1.0, 1e9), st.floats(-math.pi, math.pi), st.floats(-1e9, 1e9))
def test_however_much_a_hand_asks_for_it_gets_the_most_that_way(excess, angle, turn):
    asked, command = ROBOT.max_speed * np.array([math.cos(angle), math.sin(angle)]), sent([0.0, 0.0])
    for _ in range(200):
        command = hand_command(Hand(excess * asked, turn, 0.0), command, False, SETTINGS)
    assert (command.maneuver, command.reason) == (HAND, "")
    assert command.velocity == pytest.approx(asked, abs=1e-9)
    assert command.yaw_rate == pytest.approx(min(max(turn, -ROBOT.max_yaw_rate), ROBOT.max_yaw_rate))


@QUICK
@given(st.floats(-0.5, 1.0))
def test_it_has_the_robot_until_its_command_is_old(age):
    assert has_robot(hand(0.1), 1.0 + age, LIMITS) == (0.0 <= (1.0 + age) - 1.0 <= LIMITS.hand_age)


@pytest.mark.parametrize(
    ("given_", "stands", "lost", "position", "limits", "reason"),
    [
        (hand(), "", "", None, LIMITS, ""),
        (hand(), "", "no pose yet", None, LIMITS, ""),
        (hand(), "emergency stop by its service", "", None, LIMITS, "emergency stop by its service"),
        (hand(trouble="2 nodes publish"), "", "", None, LIMITS, "2 nodes publish"),
        (hand(), "", "", (0.5, 0.5), FENCED, ""),
        (hand(), "", "", (1.5, 0.5), FENCED, "the robot at 1.50, 0.50 is outside of limits.fence"),
        (hand(), "", "pose old", (0.5, 0.5), FENCED, "not known to be within limits.fence: pose old"),
        (hand(), "", "", None, FENCED, "not known to be within limits.fence: no pose yet"),
    ],
)
def test_by_hand_what_forbids_it(given_, stands, lost, position, limits, reason):
    place = None if position is None else np.array(position)
    assert why_not_by_hand(given_, stands, lost, place, limits) == reason


def test_rest_is_told_from_driving():
    assert hand().is_rest
    assert not hand(yaw_rate=0.1).is_rest
    assert not replace(hand(), velocity=np.array([0.0, 0.1])).is_rest
