"""cmd_vel as Twist or TwistStamped, by one parameter."""

import numpy as np
import pytest
from geometry_msgs.msg import Twist, TwistStamped

from collplan_core.command import FREE_SPACE, Command
from collplan_core.parameters import Settings
from collplan_ros.messages.cmd_vel import command_to_message, command_type, twist_of
from collplan_ros.messages.conversions import seconds_from_stamp

COMMAND = Command(np.array([0.3, -0.2]), 0.1, FREE_SPACE, np.zeros(2))


@pytest.mark.parametrize(("stamped", "kind"), [(False, Twist), (True, TwistStamped)])
def test_the_parameter_chooses_the_type_and_the_twist_is_the_same(stamped, kind):
    settings = Settings().with_values({"controller.stamped_cmd_vel": stamped, "frames.base": "puck"})
    message = command_to_message(COMMAND, 12.5, settings)
    assert command_type(settings) is kind
    assert isinstance(message, kind)
    twist = twist_of(message)
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == (0.3, -0.2, 0.1)
    if stamped:
        assert (seconds_from_stamp(message.header.stamp), message.header.frame_id) == (12.5, "puck")
