"""The driver against the emulated firmware: stopping in time, reconnecting, and what it says in trouble."""

import errno
import os
import pty
import signal
import subprocess
import sys
import termios
import time
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from serial_robot import SerialRobot, let_move, twist
from std_srvs.srv import Trigger
from telemetry_example import TELEMETRY
from terminal import WARN, Terminal

from collplan_core.parameters import Settings
from collplan_core.parameters.spec import ParameterError
from collplan_ros.messages.conversions import impact_contact_from_message, seconds_from_stamp
from collplan_ros.messages.qos import EVENT, LATCHED
from collplan_ros.nodes.mocap_node import MocapNode
from omnipuck_driver import port, serial_link
from omnipuck_driver.driver_node import DriverNode
from omnipuck_driver.framing import VERSION
from omnipuck_driver.messages import ARMED, BATTERY_LOW, ESTOP_LATCHED, ESTOP_PRESSED, MOTOR_FAULT, TOO_HOT, WheelCaps
from omnipuck_driver.session import Permission, WheelCommand
from omnipuck_sim.emulator.firmware import Firmware

LONGEST = Settings().limits.command_age + 1.0 / Settings().controller.rate
STANDING = 1e-3
ATTEMPTS = 10
"""Stops tried for one whose age is known: the emulator may stall itself."""
STEP = 1.0 / Settings().simulator.physics_rate
DRIVER = [sys.executable, "-c", "import sys; from omnipuck_driver.driver_node import main; sys.exit(main())"]
CONTROLLER = """
import rclpy
from geometry_msgs.msg import Twist
from collplan_ros.messages.qos import NEWEST
rclpy.init()
node = rclpy.create_node("reckless")
commands = node.create_publisher(Twist, "cmd_vel", NEWEST)
message = Twist()
message.linear.x = 0.4
node.create_timer(0.05, lambda: commands.publish(message))
rclpy.spin(node)
"""


def stop_age(robot, end) -> float | None:
    """Age of the last command at the stop after `end()`, by the emulator's clock; None where this process stalled."""
    before, lost = robot.stops, robot.emulator._room.stalled
    end()
    robot.until(lambda: robot.stops > before or robot.speed < STANDING)
    if robot.stops == before:
        # held up while it drove: the stop came, and was counted, before `end()`
        return None
    if robot.odometry[-1].pose.pose.position.x > 15.0:
        robot.call("reset")
    return robot.stop_age if robot.emulator._room.stalled == lost else None


def silences(robot, runs: int) -> list[float]:
    ages = []
    while len(ages) < runs:
        robot.go_until(lambda: robot.speed > 0.1, x=0.4)
        age = stop_age(robot, lambda: None)
        ages += [] if age is None else [age]
    return ages


def test_silence_stops_the_wheels_in_time(serial_robot):
    assert max(silences(serial_robot(), 3)) <= LONGEST + STEP


@pytest.mark.soak
@pytest.mark.timeout(2400)
def test_silence_stops_the_wheels_in_time_a_thousand_times(serial_robot):
    assert max(silences(serial_robot(), 1000)) <= LONGEST + STEP


@pytest.mark.soak
def test_a_cable_pulled_stops_the_wheels_in_time(serial_robot):
    robot = serial_robot()
    ages = []
    for _ in range(ATTEMPTS):
        robot.go_until(lambda: robot.speed > 0.1, x=0.4)
        age = stop_age(robot, lambda: robot.ask(unplugged=True))
        assert robot.stop_cause == "life"
        robot.ask(unplugged=False)
        robot.ready()
        robot.until(lambda: robot.speed < STANDING)
        ages += [] if age is None else [age]
        if len(ages) == 3:
            break
    assert len(ages) == 3, "the emulator stalled nearly each time"
    assert max(ages) <= LONGEST + STEP


def stop_age_after_kill(robot, command, victim) -> float | None:
    """Age of the last command when the robot stops after the process started by `command` is killed [s]; else None."""
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as process:
        try:
            if victim == "controller":
                with let_move(robot.ros):
                    robot.until(lambda: robot.speed > 0.1)
            else:
                robot.go_until(lambda: robot.speed > 0.1, x=0.4)
            return stop_age(robot, lambda: process.send_signal(signal.SIGKILL))
        finally:
            process.kill()


@pytest.mark.soak
@pytest.mark.parametrize(
    # while the driver lives, its own zero command races with the end of the last command's life
    ("victim", "causes"),
    [("controller", {"life", "command"}), ("driver", {"life"})],
)
def test_a_killed_process_stops_the_wheels_in_time(ros, tmp_path, victim, causes):
    robot = SerialRobot(ros, tmp_path, with_driver=victim == "controller")
    command = [sys.executable, "-c", CONTROLLER]
    if victim == "driver":
        command = [*DRIVER, "--ros-args", "-p", f"driver.port:={robot.path}"]
    else:
        # two commanders would hold the robot
        ros.probe.destroy_publisher(robot.commands)
    ages = (stop_age_after_kill(robot, command, victim) for _ in range(ATTEMPTS))
    age = next((age for age in ages if age is not None), None)
    assert age is not None, "the emulator stalled each time"
    assert age <= LONGEST + STEP
    assert robot.stop_cause in causes


def replug(robot) -> float:
    """Time from plugging in again until the robot drives, let move by a person as soon as that is taken [s]."""
    robot.go_until(lambda: robot.speed > 0.1, x=0.3)
    robot.ask(unplugged=True)
    robot.drive_until(
        lambda: "lost" in robot.driver._link.trouble() or "no such device" in robot.driver._link.trouble()
    )
    robot.until(lambda: robot.speed < STANDING)
    begun = time.monotonic()
    robot.ask(unplugged=False)
    robot.go_until(lambda: robot.speed > 0.05, x=0.3)
    if robot.odometry[-1].pose.pose.position.x > 15.0:
        robot.call("reset")
    return time.monotonic() - begun


def test_after_a_replug_it_greets_sends_zero_and_then_what_is_fresh(serial_robot, monkeypatch):
    robot = serial_robot()
    session, sent = robot.driver._link.session, []
    encode = session._encoder.encode
    monkeypatch.setattr(session._encoder, "encode", lambda message: sent.append(message) or encode(message))
    for _ in range(3):
        sent.clear()
        replug(robot)
        last = {message.session for message in sent}
        begin = next(n for n, m in enumerate(sent) if type(m).__name__ == "Hello" and m.session == sent[-1].session)
        kinds = [(type(m).__name__, any(getattr(m, "wheels", ()))) for m in sent[begin:]]
        order = [kind for n, kind in enumerate(kinds) if n == 0 or kind != kinds[n - 1]]
        assert order[:3] == [("Hello", False), ("CommandMessage", False), ("CommandMessage", True)]
        assert len(last) >= 2
    assert robot.emulator._firmware.refused == 0


@pytest.mark.soak
@pytest.mark.timeout(1200)
def test_replug_to_driving_takes_at_most_2_s_a_hundred_times(serial_robot):
    robot = serial_robot()
    assert max(replug(robot) for _ in range(100)) <= 2.0


@pytest.mark.parametrize("fault", [{"unplugged": True}, {"restarts": 1}], ids=str)
def test_after_a_lost_link_or_a_restart_nothing_moves_it_but_a_person(serial_robot, fault):
    """A hundred times: `make faults-long`."""
    robot = serial_robot()
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    robot.ask(**fault)
    robot.until(lambda: not robot.driver._link.armed)
    robot.ask(unplugged=False)
    robot.until(lambda: not robot.driver._link.trouble() and robot.speed < STANDING)
    assert "held" in robot.driver._contract._state.name
    for velocity in (0.3, 0.0, 0.3):
        begun = len(robot.odometry)
        robot.drive_until(lambda begun=begun: len(robot.odometry) > begun + 40, x=velocity)
        assert robot.speed < STANDING


def test_a_stall_of_over_a_second_holds_it(serial_robot):
    robot = serial_robot()
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    robot.ask(stall=1.2)
    for velocity in (0.3, 0.0, 0.3):
        begun = len(robot.odometry)
        robot.drive_until(lambda begun=begun: len(robot.odometry) > begun + 60, x=velocity)
    assert robot.speed < STANDING
    assert robot.driver._contract._state.name == "held"


def test_the_firmware_keeps_the_emergency_stop_over_a_restart_of_the_driver(serial_robot):
    robot = serial_robot()
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    assert robot.call("estop").success
    robot.until(lambda: robot.stop_latched)
    robot.ros.remove(robot.driver)
    robot.driver = robot.ros.make(DriverNode, robot.parameters)
    robot.until(lambda: robot.driver._contract.stopped_by == "kept by the firmware" and robot.speed < STANDING)
    assert not robot.call("resume").success
    begun = len(robot.odometry)
    robot.drive_until(lambda: len(robot.odometry) > begun + 40, x=0.3)
    assert robot.speed < STANDING
    assert robot.call("clear_estop").success
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)


def test_the_driver_keeps_the_emergency_stop_over_a_restart_of_the_firmware(serial_robot):
    robot = serial_robot()
    assert robot.call("estop").success
    robot.ask(restarts=1)
    robot.until(lambda: robot.stop_latched)
    assert robot.call("clear_estop").success
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)


def test_without_a_link_neither_the_stop_is_cleared_nor_the_robot_let_move(serial_robot):
    robot = serial_robot()
    assert robot.call("estop").success
    robot.ask(unplugged=True)
    robot.until(lambda: robot.driver._link.trouble())
    answer = robot.call("clear_estop")
    assert not answer.success
    assert "the firmware, which keeps it, is not there" in answer.message
    robot.ask(unplugged=False)
    robot.ready()
    assert robot.call("clear_estop").success


@pytest.mark.parametrize(
    ("fault", "words"),
    [pytest.param("motor_fault", "a motor has failed", marks=pytest.mark.soak), ("too_hot", "too hot")],
)
def test_a_failed_motor_and_heat_stop_it_at_once_and_hold_it(serial_robot, fault, words):
    robot = serial_robot()
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    stops = robot.stops
    robot.ask(**{fault: True})
    robot.drive_until(lambda: robot.stops > stops and robot.speed < STANDING, x=0.3)
    assert robot.stop_cause == words.replace("a motor has failed", "motor fault")
    robot.drive_until(lambda: words in robot.said["/driver_node"], x=0.3)
    answer = robot.call("resume")
    assert (answer.success, answer.message) == (False, words)
    robot.ask(**{fault: False})
    begun = len(robot.odometry)
    robot.drive_until(lambda: len(robot.odometry) > begun + 40, x=0.3)
    assert robot.speed < STANDING
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)


@pytest.mark.soak
def test_with_a_low_battery_it_goes_on_to_its_goal_and_refuses_the_next(serial_robot):
    robot = serial_robot()
    planner = robot.ros.publisher(GoalStatus, "goal_status", LATCHED)
    for n in (1, 2):
        robot.ros.wait_until(lambda: False, 0.1)
        message = GoalStatus(status=GoalStatus.STATUS_EXECUTING)
        message.goal_info.goal_id.uuid = np.full(16, n, dtype=np.uint8)
        planner.publish(message)
    robot.drive_until(lambda: robot.speed > 0.2, x=0.3)
    robot.ask(battery=6.2)
    robot.until(lambda: robot.driver._link.session.telemetry.status & BATTERY_LOW)
    begun = len(robot.odometry)
    robot.drive_until(lambda: len(robot.odometry) > begun + 40 and robot.speed > 0.2, x=0.3)
    message.goal_info.goal_id.uuid = np.full(16, 3, dtype=np.uint8)
    planner.publish(message)
    robot.drive_until(lambda: robot.speed < STANDING, x=0.3)
    robot.drive_until(lambda: "held, the battery is low: the next goal is refused" in robot.said["/driver_node"], x=0.3)
    assert not robot.call("resume").success


def test_a_firmware_that_never_arms_is_named_and_holds_it(serial_robot, monkeypatch):
    monkeypatch.setattr(Firmware, "_take_acts", lambda firmware, acts, stop, hold: setattr(firmware, "_acts", acts))
    robot = serial_robot()
    robot.ready()
    assert robot.call("resume").success
    robot.drive_until(lambda: "the firmware does not arm" in robot.said.get("/driver_node", ""), x=0.3)
    assert robot.value("driver_node", "armed") == "no"
    assert robot.speed < STANDING


def test_a_firmware_that_drops_every_command_as_late_is_named_and_holds_it(serial_robot, monkeypatch):
    robot = serial_robot()
    said = "the firmware takes no command in time"
    with monkeypatch.context() as patched:
        # it never hears that it may move
        patched.setattr(Firmware, "_time_on_the_way", lambda firmware, sent, now: 0.4)
        assert robot.call("resume").success
        robot.drive_until(lambda: robot.driver._contract._state.name == "held", x=0.3)
        robot.drive_until(lambda: robot.driver._link.session.takes_none_in_time, x=0.3)
        robot.drive_until(lambda: said in robot.said["/driver_node"], x=0.3)
        assert not robot.call("resume").success
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    monkeypatch.setattr(Firmware, "_time_on_the_way", lambda firmware, sent, now: 0.4)
    robot.drive_until(lambda: robot.driver._contract._state.name == "held" and robot.speed < STANDING, x=0.3)
    robot.drive_until(lambda: said in robot.said["/driver_node"], x=0.3)


class LinkOf:
    """A link on which telemetry comes as the test says, all of `news` at once."""

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


@pytest.mark.parametrize(
    ("bits", "said"),
    [
        (MOTOR_FAULT, "a motor has failed"),
        (TOO_HOT, "too hot"),
        (ESTOP_PRESSED | ESTOP_LATCHED, "emergency stop by the button on the robot"),
        (0, "the firmware stands still by itself"),
    ],
)
def test_what_stopped_the_firmware_is_named_also_where_the_newest_telemetry_tells_it_no_more(ros, bits, said):
    driver = ros.make(DriverNode)
    driver._link = link = LinkOf()
    assert ros.call(Trigger, "resume").success
    told = replace(TELEMETRY, released=driver._contract.releases, status=ARMED)
    link.news = [told, told, replace(told, status=bits), replace(told, status=bits & ESTOP_LATCHED)]
    assert ros.wait_until(lambda: not driver._contract.may_move)
    assert said in driver._contract._state.message


def test_bad_lines_are_driven_over(serial_robot):
    robot = serial_robot()
    robot.ask(flipped=0.01, lost=0.05, doubled=0.05, cut=0.05, split=0.1, noise=0.1)
    robot.go_until(lambda: robot.odometry[-1].pose.pose.position.x > 0.4, x=0.6)
    decoder = robot.driver._link.session.decoder
    robot.drive_until(lambda: decoder.lost and {"crc", "repeated"} <= set(decoder.dropped), x=0.1)
    robot.ask(flipped=0.0, lost=0.0, doubled=0.0, cut=0.0, split=0.0, noise=0.0)
    robot.until(lambda: robot.speed < STANDING)


def test_a_stall_of_the_firmware_is_told_and_old_commands_are_not_made_up_for(ros, serial_robot):
    terminal = Terminal(ros)
    robot = serial_robot()
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    robot.ask(stall=0.5)
    robot.until(lambda: robot.speed < STANDING)
    assert robot.emulator._room.stalled > 0.3
    terminal.says(robot.driver, WARN, "the firmware was held up")


def test_the_button_on_the_robot_latches(serial_robot):
    robot = serial_robot()
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    robot.ask(estop_pressed=True)
    robot.drive_until(lambda: robot.speed < STANDING and "button" in robot.said["/driver_node"], x=0.3)
    assert not robot.call("clear_estop").success
    robot.ask(estop_pressed=False)
    robot.until(lambda: not robot.driver._link.session.button_pressed)
    assert robot.stop_latched
    assert robot.call("clear_estop").success
    robot.until(lambda: not robot.stop_latched)
    begun = len(robot.odometry)
    robot.drive_until(lambda: len(robot.odometry) > begun + 40, x=0.3)
    assert robot.speed < STANDING
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)


def test_battery_and_link_are_reported(serial_robot):
    robot = serial_robot()
    robot.ask(battery=6.2)
    robot.drive_until(lambda: "the battery is low" in robot.said["/driver_node"], x=0.1)
    assert float(robot.value("driver_node", "battery_v")) == pytest.approx(6.2)
    assert float(robot.value("driver_node", "quality_in")) > 0.5
    assert 0.0 <= float(robot.value("driver_node", "latency_s")) < 1.0
    assert robot.value("driver_node", "temperature_deg_c") == ""


def test_a_ring_that_senses_tells_of_impacts_in_the_map_frame(ros, tmp_path):
    told, truth = ros.listen(Vector3Stamped, "impact", EVENT), ros.listen(Vector3Stamped, "ground_truth/impact", EVENT)
    contacts = ros.listen(PoseStamped, "impact/contact", EVENT)
    robot = SerialRobot(ros, tmp_path, **{"emulator.senses_impacts": True, "mocap.accept_frozen": True})
    odometry = ros.listen(Odometry, "mocap/odom", EVENT)
    ros.make(MocapNode, {"mocap.detect_impacts": False, "mocap.accept_frozen": True})
    robot.ready()
    robot.until(lambda: odometry)

    def yaws() -> list[float]:
        return [2 * message.pose.pose.orientation.z for message in odometry[-10:]]

    robot.go_until(lambda: abs(yaws()[-1]) > 1.0, yaw_rate=1.5)
    # a robot that turns when it hits tells of it by a yaw of a moment ago
    robot.drive_until(lambda: np.ptp(yaws()) < 0.002)
    robot.drive_until(lambda: told and truth and contacts, x=-0.7, y=0.7)
    assert told[0].header.frame_id == "map"
    assert (told[0].vector.x, told[0].vector.y) == pytest.approx((truth[0].vector.x, truth[0].vector.y), abs=0.15)
    stamps = [seconds_from_stamp(m.header.stamp) for m in (told[0], truth[0])]
    assert stamps[0] == pytest.approx(stamps[1], abs=0.15)
    contact = impact_contact_from_message(contacts[0], "map")
    assert contact.time == stamps[0]
    normal = np.array([told[0].vector.x, told[0].vector.y])
    np.testing.assert_allclose(contact.normal, normal / np.hypot(*normal), atol=1e-6)
    # the hall's wall where the robot went, turned as it was: x = -1 or y = 3 or -3
    x, y = contact.point
    assert min(abs(x + 1.0), abs(abs(y) - 3.0)) < 0.02 + np.hypot(0.7, 0.7) * abs(stamps[0] - stamps[1])


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"emulator.protocol_version": 1}, f"speaks version 1 of the protocol, this driver version {VERSION}"),
        ({"emulator.protocol_version": 3}, f"speaks version 3 of the protocol, this driver version {VERSION}"),
        ({"emulator.n_wheels": 4}, "the firmware has 4 wheels, kinematics.wheel_angles 3"),
        ({"driver.baud": 57600}, "is driver.baud that of the firmware"),
    ],
)
def test_a_firmware_that_does_not_fit_is_named_and_nothing_moves(ros, tmp_path, parameters, said):
    robot = SerialRobot(ros, tmp_path, **parameters)
    robot.drive_until(lambda: said in robot.said.get("/driver_node", ""), x=0.5)
    n = len(robot.odometry)
    robot.drive_until(lambda: len(robot.odometry) > n + 30, x=0.5)
    assert robot.speed == 0.0
    assert robot.reports["/driver_node"].level == b"\x02"


def test_garbage_from_the_start_is_named(ros, tmp_path):
    master, slave = pty.openpty()
    robot = SerialRobot(ros, tmp_path, with_emulator=False, **{"driver.port": os.ttyname(slave)})
    robot.until(lambda: robot.driver._link.waits_for == "")
    os.write(master, os.urandom(2000))
    robot.until(lambda: "make no whole frames" in robot.said.get("/driver_node", ""))
    os.close(master)
    robot.until(lambda: "lost while open" in robot.driver._link.trouble() or robot.driver._link.waits_for)
    os.close(slave)


def test_a_busy_device_is_named_and_taken_when_it_is_free(ros, tmp_path):
    robot = SerialRobot(ros, tmp_path, with_driver=False)
    other = port.open_port(str(robot.path), 115200)
    driver = ros.make(DriverNode, {"driver.port": str(robot.path)})
    robot.until(lambda: "busy: another program" in robot.said.get("/driver_node", ""))
    other.close()
    robot.until(lambda: not driver._link.trouble())


@pytest.mark.parametrize(
    ("number", "said"),
    [(2, "no such device: is the cable plugged in"), (13, "no permission: join group"), (5, "broken")],
)
def test_a_device_that_cannot_be_opened_says_what_to_do(number, said):
    assert said in port.described("/dev/ttyUSB0", 115200, OSError(number, os.strerror(number)))


@pytest.mark.parametrize("call", ["tcsetattr", "tcflush"])
@pytest.mark.parametrize(("number", "said"), [(errno.EIO, "broken"), (errno.ENODEV, "no such device")])
def test_a_cable_pulled_while_the_device_is_opened_is_told(monkeypatch, call, number, said):
    def gone(*arguments):
        raise termios.error(number, os.strerror(number))

    master, slave = pty.openpty()
    monkeypatch.setattr(termios, call, gone)
    with pytest.raises(port.PortError, match=said):
        port.open_port(os.ttyname(slave), 115200)
    os.close(master)
    os.close(slave)


def test_a_file_is_no_device(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(port.PortError, match="not a serial device"):
        port.open_port(str(tmp_path / "file"), 115200)


def test_attempts_to_open_come_ever_more_seldom(monkeypatch):
    times, now = [], 0.0

    def refuse(path, baud):
        times.append(now)
        raise port.PortError("no")

    monkeypatch.setattr(serial_link, "open_port", refuse)
    link = serial_link.SerialLink(Settings().driver, 3, WheelCaps(70.5, 500.0))
    while now < 5.0:
        link.receive(now)
        now += 0.02
    pauses = [b - a for a, b in pairwise(times)]
    assert pauses == sorted(pauses)
    assert pauses[0] < 0.1 < 0.9 < pauses[-1] < 1.1


def test_no_more_waits_in_the_device_than_leaves_it_in_20_ms(monkeypatch):
    port_ = SimpleNamespace(out_waiting=0, read=lambda most: b"", write=lambda frame: None)
    monkeypatch.setattr(serial_link, "open_port", lambda path, baud: port_)
    monkeypatch.setattr(serial_link, "select", lambda *_: ([], [port_], []))
    for baud, most in ((9600, 19), (115200, 230)):
        link = serial_link.SerialLink(replace(Settings().driver, baud=baud), 3, WheelCaps(70.5, 500.0))
        link.receive(0.0)
        for n, port_.out_waiting in enumerate([most, most + 1]):
            link.send(WheelCommand((0.0,) * 3, 0.0, 0.2), Permission(False, True, 0, 0), float(n))
            assert (link.sent, link.unsent) == (1, n)


@pytest.mark.parametrize(
    ("key", "value"), [("kinematics.wheel_radius", 0.0), ("kinematics.wheel_angles", [0.0] * 3), ("driver.rate", 5.0)]
)
def test_parameters_out_of_range_are_refused_at_the_start(ros, key, value):
    with pytest.raises(ParameterError, match=key):
        ros.make(DriverNode, {key: value})


def test_as_a_process_it_sends_zero_at_its_end(ros, tmp_path):
    robot = SerialRobot(ros, tmp_path, with_driver=False)
    command = [*DRIVER, "--ros-args", "-p", f"driver.port:={robot.path}"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            robot.go_until(lambda: robot.speed > 0.2, x=0.4)
            timer = ros.probe.create_timer(0.05, lambda: robot.commands.publish(twist(x=0.4)))
            stop_age(robot, process.terminate)
            ros.probe.destroy_timer(timer)
            _, errors = process.communicate(timeout=30.0)
        finally:
            process.kill()
    assert robot.stop_cause == "command"
    assert process.returncode == 0
    assert "Traceback" not in errors
