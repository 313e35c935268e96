"""Commands within the caps of the robot's own end, whatever is commanded and set."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import Twist
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.parameters import Settings
from collplan_ros.nodes.command_check import CommandCheck

NUMBER = st.floats(allow_nan=True, allow_infinity=True)
SPEED = st.floats(-2.0, 2.0)


def twist(x: float, y: float) -> Twist:
    message = Twist()
    message.linear.x, message.linear.y = x, y
    return message


@given(
    st.lists(st.tuples(st.one_of(NUMBER, SPEED), SPEED, st.floats(0.0, 0.4)), min_size=1, max_size=20),
    st.floats(0.2, 2.0),
    st.floats(0.5, 20.0),
    st.sampled_from(("disc", "box")),
)
def test_nothing_commanded_exceeds_the_caps(commands, speed, acceleration, shape):
    caps = {"cap.speed": speed, "cap.acceleration": acceleration}
    used = Settings().with_values({**caps, "robot.max_speed": 2.0, "robot.velocity_shape": shape})
    check, now, before = CommandCheck(used), 0.0, np.zeros(2)
    period = 1.0 / used.controller.rate
    last = now
    for x, y, pause in commands:
        last, now = now, now + pause
        if now - last > used.limits.command_age:
            before = np.zeros(2)  # the robot stands by then
        velocity, _ = check.followed(twist(x, y), now)
        assert np.isfinite(velocity).all()
        assert (math.hypot(*velocity) if shape == "disc" else np.abs(velocity).max()) <= speed * (1 + 1e-9)
        change = math.hypot(*(velocity - before))
        assert not velocity.any() or change <= acceleration * period * (1 + 1e-6) + 1e-9
        before = velocity


def test_by_hand_the_cap_of_a_box_lets_each_axis_through_on_its_own():
    for shape, most in (("disc", 0.6 / math.sqrt(2.0)), ("box", 0.6)):
        check = CommandCheck(Settings().with_values({"robot.velocity_shape": shape, "cap.speed": 0.6}))
        assert check.followed(twist(1.0, -1.0), 0.0)[0].tolist() == [pytest.approx(most), pytest.approx(-most)]


def test_a_stop_is_followed_at_once():
    check = CommandCheck(Settings())
    for n in range(10):
        velocity, _ = check.followed(twist(1.2, 0.0), 0.05 * n)
    assert velocity.tolist() == [1.2, 0.0]
    assert check.followed(twist(0.0, 0.0), 0.5)[0].tolist() == [0.0, 0.0]
    check.followed(twist(1.2, 0.0), 0.55)
    assert check.followed(twist(math.nan, 0.0), 0.6)[0].tolist() == [0.0, 0.0]


def test_commands_without_end_do_not_outrun_the_cap():
    check = CommandCheck(Settings().with_values({"cap.acceleration": 10.0}))
    for n in range(100):
        velocity, _ = check.followed(twist(1.2, 0.0), 1.0 + 1e-4 * n)
    assert velocity[0] <= 0.5 + 10.0 * 1e-2  # after silence: one period of the controller


def test_as_shipped_a_rebound_reverses_the_command_within_a_control_period():
    check = CommandCheck(Settings())
    for n, vx in enumerate((1.2, -1.2)):
        velocity, _ = check.followed(twist(vx, 0.0), 1.0 + 0.05 * n)
    assert velocity.tolist() == [-1.2, 0.0]


def test_a_live_limit_is_used_from_the_next_command_on():
    check = CommandCheck(Settings())
    check.change_settings(Settings().with_values({"robot.max_speed": 0.2}))
    assert check.followed(twist(0.25, 0.0), 0.0)[0].tolist() == [0.2, 0.0]
