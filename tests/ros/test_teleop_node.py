"""teleop_node in this process, with a joystick and a robot's services of the test's own."""

import math
import time

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import Joy
from std_srvs.srv import Trigger
from terminal import WARN, Terminal

from collplan_core.control.sender_age import SILENCE
from collplan_core.parameters import Settings
from collplan_ros.messages.conversions import asks_for_rest
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT
from collplan_ros.nodes.teleop_node import TeleopNode

TELEOP = Settings().teleop
FULL = TELEOP.speed_share * Settings().robot.max_speed
PERIOD = 0.03


class Pad:
    """A joystick that sends while the test waits, and all that comes of it."""

    def __init__(self, ros, kind=Twist, **parameters) -> None:
        self.ros = ros
        self.called: list[str] = []
        for name in ("estop", "resume"):
            ros.probe.create_service(Trigger, name, lambda request, response, name=name: self._answer(name, response))
        self.commands = ros.listen(kind, "hand/cmd_vel", EVENT)
        self.reports = ros.listen(DiagnosticArray, "/diagnostics", DIAGNOSTICS_SUBSCRIBED)
        self.message = Joy(axes=[0.0] * 4, buttons=[0] * 8)
        self.sends = True
        self.node = ros.make(TeleopNode, parameters)
        self._joy = ros.publisher(Joy, "joy", 10)
        ros.probe.create_timer(PERIOD, self._send, clock=Clock(clock_type=ClockType.STEADY_TIME))
        assert ros.wait_until(lambda: self.node._grip.was_released)
        assert ros.wait_until(lambda: all(client.service_is_ready() for client in self.node._calls._kept.values()))

    def _answer(self, name, response):
        self.called.append(name)
        response.success = True
        return response

    def _send(self) -> None:
        if self.sends:
            self._joy.publish(self.message)

    def show(self, forward=0.0, pressed=()) -> None:
        self.message.axes[TELEOP.forward_axis] = forward
        self.message.buttons = [int(button in pressed) for button in range(8)]

    def drive(self) -> None:
        self.show(1.0, (TELEOP.dead_man_button,))
        assert self.ros.wait_until(lambda: self.commands and self.commands[-1].linear.x == pytest.approx(FULL))

    def stands(self) -> bool:
        return asks_for_rest(self.commands[-1])

    def wait_until_silent(self) -> None:
        """The last command is zero, and no other one comes."""
        assert self.ros.wait_until(self.stands)
        n = len(self.commands)
        self.ros.spin(0.2)
        assert len(self.commands) == n


@pytest.fixture
def pad(ros):
    return Pad(ros)


def test_the_stick_counts_while_the_dead_man_button_is_pressed(ros, pad):
    pad.show(1.0)
    ros.spin(0.3)
    assert pad.commands == []
    pad.drive()
    pad.show(1.0)
    pad.wait_until_silent()
    assert sum(asks_for_rest(command) for command in pad.commands) == 1


def test_a_joystick_that_falls_silent_has_let_go_until_it_was_released(ros, pad):
    pad.drive()
    pad.sends = False
    begun = time.monotonic()
    assert ros.wait_until(pad.stands)
    assert time.monotonic() - begun > TELEOP.joy_age - 2 * PERIOD
    pad.sends = True
    pad.wait_until_silent()
    pad.show()
    assert ros.wait_until(lambda: pad.node._grip.was_released)
    pad.drive()


@pytest.mark.parametrize("broken", [{"axes": [0.0]}, {"buttons": []}, {"axes": [float("nan")] * 4}])
def test_a_message_that_is_no_joystick_stops(ros, pad, broken):
    pad.drive()
    for name, value in broken.items():
        setattr(pad.message, name, value)
    pad.wait_until_silent()
    assert pad.node._inputs.refusals["joy"] >= 1
    assert ros.wait_until(lambda: pad.node._health().message.startswith(f"joy refused: {next(iter(broken))}"))


def test_the_stop_button_calls_estop_once_and_lets_go(ros, pad):
    pad.drive()
    pad.show(1.0, (TELEOP.dead_man_button, TELEOP.stop_button))
    assert ros.wait_until(lambda: pad.called)
    pad.wait_until_silent()
    pad.show(1.0, (TELEOP.dead_man_button,))
    pad.wait_until_silent()
    assert pad.called == ["estop"]


def test_two_joysticks_drive_nothing_and_are_named_and_one_stops(ros, pad):
    pad.drive()
    other = ros.add(rclpy.create_node("other_joy", context=ros.context))
    other.create_publisher(Joy, "joy", 10)
    pad.wait_until_silent()
    expected = "2 nodes publish /joy: /other_joy, /probe; end all but one"
    assert pad.node._inputs.refusals.newest == expected
    pad.show(0.0, (TELEOP.stop_button,))
    assert ros.wait_until(lambda: pad.called == ["estop"])
    ros.remove(other)
    pad.show()
    assert ros.wait_until(lambda: pad.node._grip.was_released)
    pad.drive()


def test_a_press_of_the_stop_button_is_heard_after_a_stall_and_nothing_else(ros, pad):
    pad.drive()
    pad.show(1.0, (TELEOP.dead_man_button, TELEOP.stop_button))
    for _ in range(8):
        pad._joy.publish(pad.message)
        pad.show(1.0, (TELEOP.dead_man_button,))
    time.sleep(1.5 * TELEOP.joy_age)
    driven = len(pad.commands)
    assert ros.wait_until(lambda: pad.called)
    assert ros.wait_until(pad.stands)
    ros.spin(0.2)
    assert not any(command.linear.x for command in pad.commands[driven + 1 :])
    assert pad.called == ["estop"]
    assert pad.node._inputs.refusals.newest.endswith("where a clock was set, restart joy_node")


def test_a_message_of_unknown_age_counts_for_no_button(ros, pad):
    """After a silence another joystick may have sent it, or this one while the node did not run."""
    pad.show()
    pad.sends = False
    ros.spin(1.1 * SILENCE)
    watch = pad.node._inputs._watches["joy"]
    taken = watch.n_taken
    pad._joy.publish(pad.message)
    time.sleep(1.5 * TELEOP.joy_age)
    assert ros.wait_until(lambda: watch.n_taken > taken)
    assert pad.node._grip.since == math.inf
    pad.sends = True
    assert ros.wait_until(lambda: pad.node._grip.was_released)


def test_resume_is_called_with_the_dead_man_button_released_alone(ros, pad):
    pad.drive()
    pad.show(1.0, (TELEOP.dead_man_button, TELEOP.resume_button))
    ros.spin(0.3)
    assert pad.called == []
    pad.show()
    pad.wait_until_silent()
    pad.show(0.0, (TELEOP.resume_button,))
    assert ros.wait_until(lambda: pad.called)
    ros.spin(0.2)
    assert pad.called == ["resume"]


def test_resume_is_not_called_with_a_dead_man_button_that_is_pressed_and_does_not_count(ros, pad):
    both = (TELEOP.dead_man_button, TELEOP.resume_button)
    pad.show(0.0, both)
    assert ros.wait_until(lambda: pad.node._grip.holds)
    pad.sends = False
    assert ros.wait_until(lambda: not pad.node._grip.was_released)
    pad.show(0.0, both[:1])
    pad.sends = True
    assert ros.wait_until(lambda: pad.node._resume.was_released)
    pad.show(0.0, both)
    assert ros.wait_until(lambda: pad.node._resume.holds)
    ros.spin(0.1)
    assert not pad.node._grip.was_released
    assert pad.called == []


@pytest.mark.parametrize("button", [TELEOP.dead_man_button, TELEOP.resume_button])
def test_a_button_that_is_pressed_when_a_joystick_is_opened_counts_once_it_was_released(ros, pad, button):
    """joy_node shows all of them released at first."""
    pad.sends = False
    assert ros.wait_until(lambda: not pad.node._grip.was_released)
    pad.show(1.0)
    pad._joy.publish(pad.message)
    assert ros.wait_until(lambda: pad.node._grip.since < math.inf)
    pad.show(1.0, (button,))
    pad.sends = True
    ros.spin(0.4)
    assert (pad.commands, pad.called) == ([], [])
    pad.show(1.0)
    assert ros.wait_until(lambda: pad.node._grip.was_released and pad.node._resume.was_released)
    pad.show(1.0, (button,))
    assert ros.wait_until(lambda: pad.commands or pad.called)


def test_a_press_that_does_not_count_is_told_once_also_of_a_joystick_that_does_not_repeat(ros):
    terminal = Terminal(ros)
    pad = Pad(ros)
    pad.sends = False
    for _ in range(2):
        assert ros.wait_until(lambda: not pad.node._grip.was_released)
        for pressed in ((TELEOP.dead_man_button,), ()):
            pad.show(1.0, pressed)
            pad._joy.publish(pad.message)
            ros.spin(1.5 * TELEOP.joy_age)
    line = "the dead-man button is pressed, and counts once it was released for 0.3 s, in messages at most 0.2 s apart"
    terminal.says(pad.node, WARN, line)
    assert [text for _, text in terminal.lines(pad.node)].count(line) == 1
    assert pad.commands == []


def test_its_health_says_what_it_waits_for(ros, pad):
    def said() -> str:
        pad.node._diagnostics.publish()
        return pad.reports[-1].status[0].message if pad.reports else ""

    assert ros.wait_until(lambda: said() == "dead-man button released")
    pad.drive()
    assert ros.wait_until(lambda: said() == "drives")
    pad.sends = False
    assert ros.wait_until(lambda: said() == "the joystick is silent")
    pad.sends = True
    assert ros.wait_until(lambda: said() == "waits until the dead-man button is released")
    pad.show()
    assert ros.wait_until(lambda: said() == "dead-man button released")
    commands = next(each for each in ros.probe.subscriptions if each.topic_name == "/hand/cmd_vel")
    ros.probe.destroy_subscription(commands)
    assert ros.wait_until(lambda: said() == "nobody listens to hand/cmd_vel: controller_node is to run")


def test_it_stops_the_robot_when_it_ends(ros, pad):
    pad.drive()
    pad.node.stop()
    ros.remove(pad.node)
    assert ros.wait_until(pad.stands)


def test_stamped_commands(ros):
    pad = Pad(ros, TwistStamped, **{"controller.stamped_cmd_vel": True})
    pad.show(1.0, (TELEOP.dead_man_button,))
    assert ros.wait_until(lambda: pad.commands)
    assert pad.commands[0].header.frame_id == "base_link"
    assert pad.commands[0].twist.linear.x == pytest.approx(FULL)
