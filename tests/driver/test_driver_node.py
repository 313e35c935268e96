"""The driver against the emulated firmware: stopping in time, reconnecting, and what it says in trouble."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus
from serial_robot import SerialRobot
from std_srvs.srv import Trigger
from telemetry_example import TELEMETRY
from terminal import WARN, Terminal

from collplan_ros.messages.qos import LATCHED
from omnipuck_driver.codec import Encoder
from omnipuck_driver.driver_node import BATTERY, FAULTS, LOGGED, DriverNode
from omnipuck_driver.framing import VERSION
from omnipuck_driver.messages import (
    ARMED,
    BATTERY_LOW,
    ESTOP_LATCHED,
    ESTOP_PRESSED,
    MOTOR_FAULT,
    STALLED,
    TOO_HOT,
    CommandMessage,
    Hello,
)
from omnipuck_driver.session import TOO_LATE
from omnipuck_sim.emulator.firmware import Firmware

STANDING = 1e-3


def stays_still(robot, velocities=(0.3, 0.0, 0.3), poses: int = 30) -> bool:
    begun = len(robot.odometry)
    for k, velocity in enumerate(velocities, 1):
        robot.drive_until(lambda k=k: len(robot.odometry) > begun + k * poses, x=velocity)
    return robot.speed < STANDING


def test_at_its_end_it_sends_zero(serial_robot):
    robot = serial_robot()
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    robot.ros.hold(robot.driver)
    stops = robot.stops
    robot.driver.stop()
    robot.until(lambda: robot.stops > stops)
    assert robot.stop_cause == "command"


def test_after_a_replug_it_greets_sends_zero_and_then_what_is_fresh(serial_robot, monkeypatch):
    robot, sent = serial_robot(), []
    encode = Encoder.encode
    monkeypatch.setattr(Encoder, "encode", lambda self, message: sent.append(message) or encode(self, message))
    robot.go_until(lambda: robot.speed > 0.1, x=0.3)
    robot.ask("unplugged")
    robot.drive_until(lambda: robot.driver.link.trouble(), x=0.3)
    robot.until(lambda: robot.speed < STANDING)
    sent.clear()
    robot.ask("")
    robot.ready()
    assert robot.state == "held"
    assert stays_still(robot)
    robot.go_until(lambda: robot.speed > 0.05, x=0.3)
    of_driver = [message for message in sent if isinstance(message, Hello | CommandMessage)]
    begin = next(k for k, m in enumerate(of_driver) if isinstance(m, Hello) and m.session == of_driver[-1].session)
    kinds = [(type(m), any(getattr(m, "wheels", ()))) for m in of_driver[begin:]]
    order = [kind for k, kind in enumerate(kinds) if k == 0 or kind != kinds[k - 1]]
    assert order[:3] == [(Hello, False), (CommandMessage, False), (CommandMessage, True)]


def test_a_firmware_that_restarts_or_stalls_holds_it(ros, serial_robot):
    terminal = Terminal(ros)
    robot = serial_robot()
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    robot.ask("restarts=1")
    robot.until(lambda: not robot.driver.link.armed)
    robot.ready()
    assert robot.state == "held"
    assert stays_still(robot)
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    # old commands are not made up for
    robot.ask("restarts=1, stall=0.5")
    robot.until(lambda: robot.speed < STANDING)
    assert robot.stalled > 0.3
    terminal.says(robot.driver, WARN, LOGGED[STALLED])
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    robot.ask("restarts=1, stall=1.2")
    assert stays_still(robot, poses=50)
    assert robot.state == "held"


@pytest.mark.soak
def test_the_emergency_stop_outlives_driver_and_firmware_and_is_not_cleared_without_a_link(serial_robot):
    robot = serial_robot()
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    assert robot.call("estop").success
    robot.until(lambda: robot.stop_latched)
    robot.ros.remove(robot.driver)
    robot.driver = robot.ros.make(DriverNode, robot.parameters)
    robot.until(lambda: "kept" in robot.driver.contract.stopped_by and robot.speed < STANDING)
    assert not robot.call("resume").success
    assert stays_still(robot)
    sessions = robot.driver.link.session.begun
    robot.ask("restarts=1")
    robot.until(lambda: robot.driver.link.session.begun > sessions and robot.stop_latched)
    robot.ask("restarts=1, unplugged")
    robot.until(lambda: robot.driver.link.trouble())
    answer = robot.call("clear_estop")
    assert not answer.success
    assert "not there" in answer.message
    robot.ask("restarts=1")
    robot.ready()
    assert robot.call("clear_estop").success
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)


def test_with_a_low_battery_it_goes_on_to_its_goal_and_refuses_the_next(serial_robot):
    robot = serial_robot()
    planner = robot.ros.publisher(GoalStatus, "goal_status", LATCHED)
    message = GoalStatus(status=GoalStatus.STATUS_EXECUTING)

    def give_goal(n: int) -> None:
        message.goal_info.goal_id.uuid = np.full(16, n, dtype=np.uint8)
        planner.publish(message)
        robot.ros.spin(0.1)

    give_goal(1)
    give_goal(2)
    robot.drive_until(lambda: robot.speed > 0.2, x=0.3)
    robot.ask("battery=6.2")
    robot.drive_until(lambda: robot.driver.link.session.telemetry.status & BATTERY_LOW, x=0.3)
    begun = len(robot.odometry)
    robot.drive_until(lambda: len(robot.odometry) > begun + 40 and robot.speed > 0.2, x=0.3)
    give_goal(3)
    robot.drive_until(lambda: robot.speed < STANDING and BATTERY[BATTERY_LOW] in robot.said["/driver_node"], x=0.3)
    assert not robot.call("resume").success
    assert float(robot.value("driver_node", "battery_v")) == pytest.approx(6.2)
    assert float(robot.value("driver_node", "quality_in")) > 0.0


def test_a_firmware_that_never_arms_is_named_and_holds_it(serial_robot, monkeypatch):
    monkeypatch.setattr(Firmware, "_take_acts", lambda firmware, acts, stop, hold: setattr(firmware, "_acts", acts))
    robot = serial_robot()
    assert robot.call("resume").success
    robot.drive_until(lambda: "does not arm" in robot.said.get("/driver_node", ""), x=0.3)
    assert robot.value("driver_node", "armed") == "no"
    assert robot.speed < STANDING


def test_a_firmware_that_drops_every_command_as_late_is_named_and_holds_it(serial_robot, monkeypatch):
    robot = serial_robot()
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    monkeypatch.setattr(Firmware, "_time_on_the_way", lambda firmware, sent, now: 0.4)
    robot.drive_until(lambda: robot.state == "held" and robot.speed < STANDING, x=0.3)
    robot.drive_until(lambda: TOO_LATE in robot.said["/driver_node"], x=0.3)
    robot.drive_until(lambda: robot.driver.link.session.takes_none_in_time, x=0.3)
    assert not robot.call("resume").success


class LinkOf:
    """A link whose telemetry is `news`, all at once."""

    armed = False

    def __init__(self) -> None:
        self.news = []
        self.session = SimpleNamespace(
            begun=1, connected=True, announced=None, telemetry=None, takes_none_in_time=False
        )

    def receive(self, now: float) -> list:
        news, self.news = self.news, []
        self.session.telemetry = news[-1] if news else self.session.telemetry
        return news

    def trouble(self) -> str:
        return ""

    def send(self, *what: object) -> None:
        pass

    def close(self) -> None:
        pass


def test_what_stopped_the_firmware_is_named_also_where_the_newest_telemetry_tells_it_no_more(ros):
    for bits, said in (
        (MOTOR_FAULT, FAULTS[MOTOR_FAULT]),
        (TOO_HOT, FAULTS[TOO_HOT]),
        (ESTOP_PRESSED | ESTOP_LATCHED, "button"),
        (0, "stands still by itself"),
    ):
        driver = ros.make(DriverNode)
        driver.link = link = LinkOf()
        states = ros.listen(DiagnosticStatus, "robot/state", LATCHED)
        assert ros.call(Trigger, "resume").success
        told = replace(TELEMETRY, released=driver.contract.releases, status=ARMED)
        link.news = [told, told, replace(told, status=bits), replace(told, status=bits & ESTOP_LATCHED)]
        assert ros.wait_until(lambda driver=driver: not driver.contract.may_move)
        assert ros.wait_until(lambda states=states, said=said: said in states[-1].message), (said, states[-1].message)
        ros.remove(driver)


def test_the_button_on_the_robot_latches(serial_robot):
    robot = serial_robot()
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    robot.ask("estop_pressed")
    robot.drive_until(lambda: robot.speed < STANDING and "button" in robot.said["/driver_node"], x=0.3)
    assert not robot.call("clear_estop").success
    robot.ask("")
    robot.until(lambda: not robot.driver.link.session.button_pressed)
    assert robot.stop_latched
    assert robot.call("clear_estop").success
    robot.until(lambda: not robot.stop_latched)


def test_a_firmware_that_does_not_fit_is_named_and_nothing_moves(ros, tmp_path):
    for key, value, said in (
        ("emulator.faults", f"protocol_version={VERSION + 1}", f"version {VERSION + 1} of"),
        ("emulator.faults", "n_wheels=4", "kinematics.wheel_angles 3"),
        ("driver.baud", 57600, "driver.baud"),
    ):
        robot = SerialRobot(ros, tmp_path, **{key: value})
        robot.drive_until(lambda robot=robot, said=said: said in robot.said.get("/driver_node", ""), x=0.5)
        assert stays_still(robot, (0.5,)), key
        assert robot.reports["/driver_node"].level == b"\x02", key
        for node in (robot.driver, robot.emulator):
            ros.remove(node)
        ros.probe.destroy_publisher(robot.commands)
