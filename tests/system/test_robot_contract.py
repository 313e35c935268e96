"""One contract for every robot: the simulated one, and the driver with firmware behind a serial line."""

import math
import re
import uuid
from collections.abc import Callable

import numpy as np
import pytest
import rclpy
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2
from serial_robot import HALL, let_move, twist
from std_srvs.srv import Trigger

from collplan_core.parameters import Settings
from collplan_ros.messages.cloud_reading import impact_from_cloud
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT, LATCHED, NEWEST, POSE_SUBSCRIBED
from collplan_ros.messages.reading import seconds_from_stamp
from collplan_ros.node_kit.clock import local_clock, seconds
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.nodes.mocap_node import MocapNode
from omnipuck_driver.driver_node import DriverNode
from omnipuck_sim.emulator.firmware_emulator import FirmwareEmulator
from omnipuck_sim.node.simulator_node import SimulatorNode

SETTINGS = Settings()
V_MAX = SETTINGS.robot.max_speed
POSE_PERIOD = 1.0 / SETTINGS.simulator.mocap_rate
STANDING = 1e-3
PATIENCE = 60.0
SIMULATED, REAL = "simulator_node", "driver_node"
ROBOTS = {SIMULATED: (SimulatorNode,), REAL: (DriverNode, FirmwareEmulator)}
WAITING = {"use_sim_time": True, "simulator.speed_factor": 0.0}


class Commander:
    """A node that publishes its message each period [s], silent while it has none; a simulation waits for it."""

    def __init__(self, ros, name: str, kind: type, is_simulated: bool, period: float) -> None:
        self.message = None
        overrides = [Parameter("use_sim_time", value=is_simulated)]
        self.node = ros.add(rclpy.create_node(name, context=ros.context, parameter_overrides=overrides))
        clock = local_clock(self.node)
        self.publisher = self.node.create_publisher(kind, "cmd_vel", NEWEST)
        self._timer = self.node.create_timer(period, self._send, clock=clock)

    def _send(self) -> None:
        if self.message is not None:
            self.publisher.publish(self.message)

    def falls_silent(self) -> None:
        """As a process that was killed: its publisher is listed on until its lease ends."""
        self._timer.cancel()


class Robot:
    """One robot on a graph of its own; its nodes can be ended and started again."""

    def __init__(self, ros, folder, name: str, **parameters) -> None:
        self.ros, self.name = ros, name
        (folder / "hall.yaml").write_text(HALL)
        line = str(folder / "serial")
        own = {"simulator.world": str(folder / "hall.yaml"), "emulator.link": line, "driver.port": line}
        in_time = WAITING if name == SIMULATED else {}
        self.parameters = {**own, **in_time, "simulator.noise": 0.0, **parameters}
        self.kind = TwistStamped if parameters.get("controller.stamped_cmd_vel") else Twist
        self.health = {}
        self.truth = ros.listen(Odometry, "ground_truth/odom", EVENT)
        self.poses = ros.listen(PoseStamped, "mocap/pose", POSE_SUBSCRIBED)
        self.states = ros.listen(DiagnosticStatus, "robot/state", LATCHED)
        ros.probe.create_subscription(DiagnosticArray, "/diagnostics", self._take_health, DIAGNOSTICS_SUBSCRIBED)
        self.nodes = [ros.make(kind, self.parameters) for kind in ROBOTS[name]]
        self.commander = self.new_commander("commander")
        self.ready()

    def _take_health(self, message: DiagnosticArray) -> None:
        self.health.update({status.name: status for status in message.status})

    def new_commander(self, name: str, period: float = 0.05) -> Commander:
        return Commander(self.ros, name, self.kind, self.name == SIMULATED, period)

    def ready(self) -> None:
        self.until(lambda: self.commander.publisher.get_subscription_count() > 0 and self.truth)
        self.until(lambda: f"/{self.name}" in self.health and self.own_health.level == b"\x00")

    def forget(self) -> None:
        """What was heard, also what is still under way."""
        self.ros.spin(0.3)
        for heard in (self.health, self.truth, self.states):
            heard.clear()

    def until(self, condition) -> None:
        said = lambda: {name: status.message for name, status in self.health.items()}  # noqa: E731
        assert self.ros.wait_until(condition, PATIENCE), f"waited in vain; {said()}"

    def command(self, **velocity) -> None:
        message = twist(**velocity)
        self.commander.message = TwistStamped(twist=message) if self.kind is TwistStamped else message

    def is_silent(self) -> None:
        self.commander.message = None

    def go(self, condition=None, **velocity) -> None:
        """Commands this while a person lets it move, again where a stall has held it, until it drives so."""
        speed = 0.8 * math.hypot(velocity.get("x", 0.0), velocity.get("y", 0.0))
        self.command(**velocity)
        with let_move(self.ros):
            self.until(condition or (lambda: self.speed > speed))

    def call(self, service: str) -> bool:
        return self.ros.call(Trigger, service).success

    def new_goal(self, planner, status=GoalStatus.STATUS_EXECUTING) -> None:
        message = GoalStatus(status=status)
        message.goal_info.goal_id.uuid = np.frombuffer(uuid.uuid4().bytes, dtype=np.uint8)
        planner.publish(message)
        self.passes(20)

    def later(self) -> Callable[[], list[Odometry]]:
        # on a busy machine some that are older have not been taken yet
        begun = seconds(self.commander.node.get_clock())
        return lambda: [each for each in self.truth if seconds_from_stamp(each.header.stamp) > begun]

    def passes(self, n: int) -> None:
        later = self.later()
        self.until(lambda: len(later()) > n)

    def stays_still(self, n: int = 20, **velocity) -> bool:
        """Whether it stands still for so many poses from now on, while this is commanded, or nothing."""
        self.command(**velocity) if velocity else self.is_silent()
        later = self.later()
        self.until(lambda: len(later()) > n)
        return all(speed_of(odometry) < STANDING for odometry in later())

    @property
    def own_health(self) -> DiagnosticStatus:
        return self.health[f"/{self.name}"]

    @property
    def state(self) -> str:
        return next(item.value for item in self.states[-1].values if item.key == "state") if self.states else ""

    def counted(self, key: str) -> int:
        return int(next(item.value for item in self.own_health.values if item.key == key))

    @property
    def velocity(self) -> tuple[float, float]:
        linear = self.truth[-1].twist.twist.linear
        return linear.x, linear.y

    @property
    def speed(self) -> float:
        return speed_of(self.truth[-1])


def speed_of(odometry: Odometry) -> float:
    return math.hypot(odometry.twist.twist.linear.x, odometry.twist.twist.linear.y)


@pytest.fixture(params=[SIMULATED, pytest.param(REAL, marks=pytest.mark.soak)])
def robot(request, ros, tmp_path):
    return Robot(ros, tmp_path, request.param)


@pytest.fixture
def simulated(ros, tmp_path):
    """The simulated robot alone, for what every robot has from one class and only a clock of its own can judge."""
    return Robot(ros, tmp_path, SIMULATED)


@pytest.mark.parametrize("robot", ROBOTS, indirect=True)
def test_topics_services_and_commands(robot):
    """It goes where it is told in its own frame; what is too fast is clipped, or refused, as what is no number."""
    probe = robot.ros.probe
    (taken,) = probe.get_subscriptions_info_by_topic("cmd_vel")
    (given,) = probe.get_publishers_info_by_topic("mocap/pose")
    assert (taken.node_name, taken.topic_type) == (robot.name, "geometry_msgs/msg/Twist")
    assert given.topic_type == "geometry_msgs/msg/PoseStamped"
    for profile in (taken.qos_profile, given.qos_profile):
        assert profile.reliability == ReliabilityPolicy.RELIABLE
        assert profile.durability == DurabilityPolicy.VOLATILE
    services = dict(probe.get_service_names_and_types())
    for name in ("/estop", "/clear_estop", "/resume", "/reset"):
        assert services[name] == ["std_srvs/srv/Trigger"]
    robot.until(lambda: robot.poses)
    assert robot.poses[-1].header.frame_id == "map"

    robot.go(lambda: robot.velocity[1] > 0.45, y=0.5)
    assert abs(robot.velocity[0]) < STANDING
    robot.go(lambda: robot.velocity[0] > 0.45, x=0.5)
    assert robot.call("clear_estop"), "changes nothing where nothing is stopped"
    robot.go(lambda: 0.97 * V_MAX < robot.speed <= V_MAX + 1e-5, x=1.1 * V_MAX, y=-0.55 * V_MAX)
    robot.until(lambda: robot.counted("clipped") > 0)
    assert max(map(speed_of, robot.truth)) <= V_MAX + 1e-5
    for bad in ({"yaw_rate": math.inf}, {"x": 1.51 * V_MAX}):
        assert robot.call("reset")
        robot.go(x=0.3)
        refused = robot.counted("refused")
        robot.command(**bad)
        robot.until(lambda: robot.speed < STANDING)
        robot.until(
            lambda refused=refused: robot.counted("refused") > refused and "refused" in robot.own_health.message
        )
        assert robot.own_health.level == b"\x01", bad


def test_silence_stops_it_and_over_a_second_holds_it(robot):
    robot.go(x=0.4)
    robot.is_silent()
    robot.until(lambda: robot.speed < 0.2)
    robot.command(x=0.4)
    robot.until(lambda: robot.speed > 0.3)
    robot.is_silent()
    robot.until(lambda: robot.state == "held")
    silence = re.search(r"no fresh command for ([0-9.]+) s", robot.states[-1].message)
    assert silence, robot.states[-1].message
    assert float(silence[1]) >= 1.0
    assert robot.stays_still(x=0.4)
    robot.go(x=0.4)


def test_after_an_emergency_stop_no_command_and_no_silence_moves_it(robot):
    robot.go(x=0.4)
    assert robot.call("estop")
    robot.until(lambda: robot.speed < STANDING)
    assert robot.stays_still(x=0.4)
    robot.until(lambda: "emergency stop" in robot.own_health.message)
    assert robot.own_health.level == b"\x01"
    assert not robot.call("resume"), "not while it is latched"
    late, said = (robot.ros.listen(DiagnosticStatus, "robot/state", profile) for profile in (LATCHED, EVENT))
    robot.until(lambda: late and len(said) > 1)
    assert {item.key: item.value for item in late[0].values}["state"] == "stopped"
    assert {message.message for message in said} == {late[0].message}, "said again for who has missed it"
    for _ in range(2):
        robot.until(lambda: robot.call("clear_estop"))
        robot.until(lambda: robot.state == "held")
        for velocity in (0.0, 0.4, math.nan):
            assert robot.stays_still(x=velocity)
        # as a controller does that loses its poses for a moment
        assert robot.stays_still(round((SETTINGS.limits.command_age + 0.1) / POSE_PERIOD))
    assert robot.counted("ignored") > 0
    robot.go(x=0.4)
    robot.until(lambda: robot.state == "free")


def test_a_new_goal_lets_it_move_and_the_one_of_before_does_not(simulated):
    planner = simulated.ros.publisher(GoalStatus, "goal_status", LATCHED)
    simulated.command(x=0.4)
    simulated.new_goal(planner)
    assert simulated.stays_still(x=0.4), "the first goal heard of may be one of before its start"
    simulated.new_goal(planner)
    simulated.until(lambda: simulated.speed > 0.3)
    assert simulated.call("estop")
    simulated.until(lambda: simulated.speed < STANDING)
    simulated.new_goal(planner)
    assert simulated.call("clear_estop")
    assert simulated.stays_still(x=0.4), "a goal given during the stop is none given after it"
    simulated.new_goal(planner, GoalStatus.STATUS_ABORTED)
    assert simulated.stays_still(x=0.4), "a goal that was refused"
    simulated.new_goal(planner)
    simulated.until(lambda: simulated.speed > 0.3)


def test_a_second_commander_holds_it_and_is_named_and_a_restart_is_no_second_one(simulated):
    for _ in range(3):
        simulated.commander.falls_silent()
        simulated.commander = simulated.new_commander("commander")
        simulated.go(x=0.1)
        simulated.passes(70)  # three restarts within a second are two publishers
    assert not any("publish" in each.message for each in simulated.states)
    for name, named in (("teleop", "/commander, /teleop"), ("commander", "both named /commander")):
        simulated.go(x=0.1)
        rogue = simulated.new_commander(name, period=0.03)
        rogue.message = simulated.commander.message
        simulated.until(
            lambda named=named: simulated.own_health.level == b"\x02" and named in simulated.own_health.message
        )
        simulated.until(lambda: simulated.speed < STANDING)
        assert simulated.stays_still(x=0.1)
        assert not simulated.call("resume")
        simulated.until(lambda named=named: simulated.state == "held" and named in simulated.states[-1].message)
        rogue.falls_silent()
        simulated.ros.remove(rogue.node)
        simulated.until(lambda: simulated.call("resume"))


def test_a_command_that_was_long_under_way_is_not_followed(simulated, monkeypatch):
    simulated.go(x=0.2)
    # simulated time may be slower than the clock
    delayed = property(lambda self: self.came - 10.0, lambda self, value: setattr(self, "came", value))
    monkeypatch.setattr(Inputs, "sent", delayed, raising=False)
    simulated.until(lambda: simulated.speed < STANDING and simulated.counted("late") > 0)


def test_an_impact_has_its_sign_and_frame_with_mocap_node_in_the_loop(ros, tmp_path):
    told, true = (ros.listen(Vector3Stamped, name, EVENT) for name in ("impact", "ground_truth/impact"))
    contacts = ros.listen(PointCloud2, "impact/contact", EVENT)
    robot = Robot(ros, tmp_path, SIMULATED, **{"simulator.noise": 0.1, "controller.stamped_cmd_vel": True})
    ros.make(MocapNode, {"use_sim_time": True})
    robot.go(lambda: robot.truth[-1].pose.pose.orientation.z < -0.5, yaw_rate=-2.0)
    robot.go(lambda: abs(robot.truth[-1].twist.twist.angular.z) < STANDING, yaw_rate=0.0)
    yaw = 2 * math.asin(robot.truth[-1].pose.pose.orientation.z)
    # to the wall at x = -1 m, whose push is along x of the map
    robot.go(lambda: told and true and contacts, x=-0.8 * math.cos(yaw), y=0.8 * math.sin(yaw))
    assert told[0].header.frame_id == contacts[0].header.frame_id == "map"
    assert told[0].vector.x > 0.8
    assert (told[0].vector.x, told[0].vector.y) == pytest.approx((true[0].vector.x, true[0].vector.y), abs=0.3)
    assert impact_from_cloud(contacts[0], "map").point[0] == pytest.approx(-1.0, abs=0.03)
    first, second, third = (seconds_from_stamp(message.header.stamp) for message in (true[0], contacts[0], told[0]))
    assert first == pytest.approx(second, abs=0.03)
    assert second < third


def test_a_robot_restarted_stands_until_a_person_lets_it_move(robot):
    for k, kind in enumerate(ROBOTS[robot.name]):
        robot.go(x=0.2)
        robot.ros.remove(robot.nodes[k])
        robot.forget()
        robot.nodes[k] = robot.ros.make(kind, robot.parameters)
        robot.until(lambda: robot.truth and robot.speed < STANDING)
        assert robot.stays_still(x=0.3)
    robot.go(x=0.2)
    assert robot.call("estop")
    robot.until(lambda: robot.state == "stopped")
    while robot.nodes:
        robot.ros.remove(robot.nodes.pop())
    robot.forget()
    # its nodes start in any order
    robot.nodes = [robot.ros.make(kind, robot.parameters) for kind in reversed(ROBOTS[robot.name])]
    robot.ready()
    assert robot.state == "held", "the emergency stop is forgotten where all of it has ended"
    assert robot.stays_still(x=0.2)
    robot.go(x=0.2)
