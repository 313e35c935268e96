"""What teleop_node makes of a joystick: commands while the dead-man button is pressed, and calls of services."""

import time

import pytest
import rclpy
from geometry_msgs.msg import Twist
from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import Joy
from std_srvs.srv import Trigger

from collplan_core.parameters import Settings
from collplan_ros.messages.conversions import asks_for_rest
from collplan_ros.messages.qos import EVENT
from collplan_ros.nodes.teleop_node import TeleopNode
from node_health import NodeHealth

TELEOP = Settings().teleop
FULL = TELEOP.speed_share * Settings().robot.max_speed
DEAD_MAN, STOP, RESUME = TELEOP.dead_man_button, TELEOP.stop_button, TELEOP.resume_button
PERIOD = 0.03
LET_GO = 0.6
"""For so long buttons are shown released, or nothing, until the node has seen that [s]."""


class Pad:
    """A joystick that sends while the test waits, and all that comes of it."""

    def __init__(self, ros, kind=Twist, **parameters) -> None:
        self.ros = ros
        self.called: list[str] = []
        for name in ("estop", "resume"):
            ros.probe.create_service(Trigger, name, lambda request, response, name=name: self._answer(name, response))
        self.commands = ros.listen(kind, "hand/cmd_vel", EVENT)
        self.message = Joy(axes=[0.0] * 4, buttons=[0] * 8)
        self.sends = True
        self.health = NodeHealth(ros, "/teleop_node")
        self.node = ros.make(TeleopNode, parameters)
        self.joy = ros.publisher(Joy, "joy", 10)
        ros.probe.create_timer(PERIOD, self._send, clock=STEADY)
        clients = {client.srv_name: client for client in self.node.clients}
        assert ros.wait_until(lambda: all(clients[name].service_is_ready() for name in ("estop", "resume")))
        ros.spin(LET_GO)

    def _answer(self, name, response):
        self.called.append(name)
        response.success = True
        return response

    def _send(self) -> None:
        if self.sends:
            self.joy.publish(self.message)
            self.sent = time.monotonic()

    def show(self, forward=0.0, pressed=()) -> None:
        self.message.axes[TELEOP.forward_axis] = forward
        self.message.buttons = [int(button in pressed) for button in range(8)]

    def drives(self) -> bool:
        return bool(self.commands) and self.commands[-1].linear.x == pytest.approx(FULL)

    def drive(self) -> None:
        """Presses until it drives, again where a stall has hidden from the node that the button was released."""
        for _ in range(5):
            self.show(1.0, (DEAD_MAN,))
            if self.ros.wait_until(self.drives, 3.0):
                return
            self.let_go()
        raise AssertionError(self.health.newest.message)

    def let_go(self) -> None:
        self.show()
        self.ros.spin(LET_GO)

    def wait_until_silent(self) -> None:
        """The last command is zero, and no other one comes."""
        assert self.ros.wait_until(lambda: asks_for_rest(self.commands[-1]))
        n = len(self.commands)
        self.ros.spin(0.2)
        assert len(self.commands) == n


STEADY = Clock(clock_type=ClockType.STEADY_TIME)


@pytest.fixture
def pad(ros):
    return Pad(ros)


def test_the_stick_counts_while_the_dead_man_button_is_pressed_and_its_health_says_so(ros, pad):
    assert pad.health.says("button released")
    pad.show(1.0)
    ros.spin(0.3)
    assert pad.commands == []
    pad.drive()
    assert pad.health.says("drives")
    pad.show(1.0)
    pad.wait_until_silent()
    commands = next(each for each in ros.probe.subscriptions if each.topic_name == "/hand/cmd_vel")
    ros.probe.destroy_subscription(commands)
    assert pad.health.says("no node subscribes")


def test_a_joystick_that_falls_silent_has_let_go_until_it_was_released(ros, pad):
    pad.drive()
    pad.sends = False
    assert ros.wait_until(lambda: asks_for_rest(pad.commands[-1]))
    assert time.monotonic() - pad.sent > TELEOP.joy_age - PERIOD
    assert pad.health.says("silent")
    pad.sends = True
    pad.wait_until_silent()
    assert pad.health.says("waiting until")
    pad.let_go()
    pad.drive()


def test_a_message_that_is_no_joystick_stops(ros, pad):
    good = pad.message
    for count, broken in enumerate(({"axes": [0.0]}, {"buttons": []}, {"axes": [float("nan")] * 4}), 1):
        pad.message = good
        pad.let_go()
        pad.drive()
        pad.message = Joy(**{"axes": good.axes, "buttons": good.buttons, **broken})
        pad.wait_until_silent()
        assert pad.health.counts("refused_joy", count)
        assert pad.health.says(f"joy refused: {next(iter(broken))}")


def test_the_stop_button_calls_estop_once_and_lets_go_also_after_a_stall(ros, pad):
    pad.drive()
    pad.show(1.0, (DEAD_MAN, STOP))
    for _ in range(8):
        pad.joy.publish(pad.message)
        pad.show(1.0, (DEAD_MAN,))
    time.sleep(1.5 * TELEOP.joy_age)
    driven = len(pad.commands)
    assert ros.wait_until(lambda: pad.called and asks_for_rest(pad.commands[-1]))
    ros.spin(0.2)
    assert not any(command.linear.x for command in pad.commands[driven + 1 :])
    assert pad.called == ["estop"]


def test_two_joysticks_drive_nothing_and_are_named_and_one_stops(ros, pad):
    pad.drive()
    other = ros.add(rclpy.create_node("other_joy", context=ros.context))
    other.create_publisher(Joy, "joy", 10)
    pad.wait_until_silent()
    assert pad.health.says("/other_joy, /probe")
    pad.show(0.0, (STOP,))
    assert ros.wait_until(lambda: pad.called == ["estop"])
    ros.remove(other)
    pad.let_go()
    pad.drive()


def test_resume_is_called_with_the_dead_man_button_released_alone(ros, pad):
    pad.drive()
    pad.show(1.0, (DEAD_MAN, RESUME))
    ros.spin(0.3)
    pad.let_go()
    assert pad.called == []
    pad.let_go()
    pad.show(0.0, (RESUME,))
    assert ros.wait_until(lambda: pad.called)
    ros.spin(0.2)
    assert pad.called == ["resume"]


def test_it_stops_the_robot_when_it_ends(ros, pad):
    pad.drive()
    pad.node.stop()
    ros.remove(pad.node)
    assert ros.wait_until(lambda: asks_for_rest(pad.commands[-1]))
