"""A joystick with a dead-man button: which velocity its stick asks for, and when a hand holds it."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.control.stick import RELEASED_FOR, Grip, Stick, StickError, check_stick, velocity_of
from collplan_core.parameters import Robot, Settings, Teleop
from collplan_core.parameters.spec import ParameterError

ROBOT = Robot()
shares = st.floats(0.0, 0.9)
teleops = st.builds(Teleop, deadzone=shares, speed_share=st.floats(0.01, 1.0), turn_share=st.floats(0.0, 1.0))
ways = st.floats(-1.5, 1.5)


def stick(forward=0.0, left=0.0, turn=0.0) -> Stick:
    return Stick((left, forward, 0.0, turn), (False,) * 8)


@given(teleops, ways, ways, ways)
def test_no_stick_asks_for_more_than_its_share_and_the_opposite_one_for_the_opposite(teleop, forward, left, turn):
    velocity, yaw_rate = velocity_of(stick(forward, left, turn), teleop, ROBOT)
    back, turned_back = velocity_of(stick(-forward, -left, -turn), teleop, ROBOT)
    assert (back.tolist(), turned_back) == (pytest.approx((-velocity).tolist()), pytest.approx(-yaw_rate))
    assert math.hypot(*velocity) <= teleop.speed_share * ROBOT.max_speed * (1.0 + 1e-9)
    assert abs(yaw_rate) <= teleop.turn_share * ROBOT.max_yaw_rate * (1.0 + 1e-9)


@given(teleops, st.floats(0.0, 1.0), st.floats(-math.pi, math.pi))
def test_within_the_deadzone_it_asks_for_rest_and_beyond_it_for_its_own_direction(teleop, way, angle):
    forward, left = way * math.cos(angle), way * math.sin(angle)
    velocity, _ = velocity_of(stick(forward, left), teleop, ROBOT)
    speed = math.hypot(*velocity)
    if way <= teleop.deadzone - 1e-9:
        assert speed == 0.0
    elif way > teleop.deadzone + 1e-6:
        assert speed > 0.0
        assert velocity / speed == pytest.approx([math.cos(angle), math.sin(angle)], abs=1e-6)


def test_by_hand_a_full_stick_asks_for_the_whole_share():
    teleop, robot = Teleop(speed_share=0.5, turn_share=0.1), Robot(max_speed=0.8)
    velocity, yaw_rate = velocity_of(stick(1.0, 0.0, -1.0), teleop, robot)
    assert velocity == pytest.approx([0.4, 0.0])
    assert yaw_rate == pytest.approx(-0.3)


def test_a_joystick_that_does_not_fit_is_refused():
    with pytest.raises(StickError, match=r"got 3, .*3"):
        velocity_of(replace(stick(), axes=(0.0,) * 3), Teleop(), ROBOT)
    with pytest.raises(StickError, match=r"axes.*nan"):
        velocity_of(replace(stick(), axes=(0.0, math.nan, 0.0, 0.0)), Teleop(), ROBOT)
    with pytest.raises(StickError, match=r"got 8, .*9"):
        stick().pressed(9)


def test_one_axis_or_button_is_not_for_two_things():
    check_stick(Settings())
    with pytest.raises(ParameterError, match=r"dead_man_button.*stop_button"):
        check_stick(Settings().with_values({"teleop.dead_man_button": 1}))
    with pytest.raises(ParameterError, match=r"left_axis.*turn_axis"):
        check_stick(Settings().with_values({"teleop.turn_axis": 0}))


@given(st.lists(st.tuples(st.booleans(), st.integers(1, 3)), max_size=20))
def test_a_hand_holds_a_button_that_is_pressed_and_was_released_for_long_before(presses):
    grip, now, released, counts = Grip(), 0.0, 0, False
    for pressed, steps in presses:
        for _ in range(steps):
            grip = grip.after(pressed, now)
            released = 0 if pressed else released + 1
            # in three messages, a little more than half of RELEASED_FOR apart
            counts = counts or released == 3
            assert (grip.was_released, grip.holds) == (counts, pressed and counts)
            now += 0.51 * RELEASED_FOR


def test_by_hand_a_release_that_a_joystick_just_opened_shows_is_none():
    grip = Grip().after(False, 1.0).after(False, 1.2).after(True, 1.25)
    assert not grip.holds
    assert grip.after(False, 1.3).after(False, 1.55).after(True, 1.56) == Grip()
    assert grip.after(False, 1.3).after(False, 1.61).after(True, 1.62).holds
