"""One contract for every robot: the simulated one, and the driver with either firmware behind a serial line.

What stands between `cmd_vel` and the robot's motion may differ; what the graph sees of it may not.
"""

import math
import time
import uuid

import numpy as np
import pytest
import rclpy
from action_msgs.msg import GoalStatus
from c_compiler import NEEDS_COMPILER
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.time import Time
from serial_robot import HALL, let_move, twist
from std_srvs.srv import Trigger

from collplan_core.parameters import Settings
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT, LATCHED, NEWEST, POSE_SUBSCRIBED
from collplan_ros.nodes.commanders import BREAK_TIME
from collplan_ros.nodes.mocap_node import MocapNode
from omnipuck_driver.driver_node import DriverNode
from omnipuck_sim.emulator.firmware_emulator import FirmwareEmulator
from omnipuck_sim.node.simulator_node import SimulatorNode

SETTINGS = Settings()
V_MAX = SETTINGS.robot.max_speed
LONGEST = SETTINGS.limits.command_age + 1.0 / SETTINGS.controller.rate
POSE_PERIOD = 1.0 / SETTINGS.simulator.mocap_rate
STANDING = 1e-3
ROBOTS = {"simulator_node": (SimulatorNode,), "driver_node": (DriverNode, FirmwareEmulator)}
KINDS = [
    pytest.param(("simulator_node", {}), id="simulator_node"),
    pytest.param(("driver_node", {}), id="driver_node"),
    pytest.param(("driver_node", {"emulator.firmware": "c"}), id="firmware in C", marks=NEEDS_COMPILER),
]


class Robot:
    """One robot on a graph of its own; its nodes can be ended and started again."""

    def __init__(self, ros, folder, name: str, **parameters) -> None:
        self.ros, self.name = ros, name
        (folder / "hall.yaml").write_text(HALL)
        line = str(folder / "serial")
        self.parameters = {
            "simulator.world": str(folder / "hall.yaml"),
            "simulator.noise": 0.0,
            "emulator.link": line,
            "driver.port": line,
            **parameters,
        }
        self.kind = TwistStamped if parameters.get("controller.stamped_cmd_vel") else Twist
        self.health = {}
        self.truth = ros.listen(Odometry, "ground_truth/odom", EVENT)
        self.poses = ros.listen(PoseStamped, "mocap/pose", POSE_SUBSCRIBED)
        self.states = ros.listen(DiagnosticStatus, "robot/state", LATCHED)
        ros.probe.create_subscription(DiagnosticArray, "/diagnostics", self._take_health, DIAGNOSTICS_SUBSCRIBED)
        self.nodes = {kind: self.start(kind) for kind in ROBOTS[name]}
        self.commands = ros.probe.create_publisher(self.kind, "cmd_vel", NEWEST)
        self.ready()

    def _take_health(self, message: DiagnosticArray) -> None:
        self.health.update({status.name: status for status in message.status})

    def start(self, kind):
        return self.ros.make(kind, self.parameters)

    def end(self, kind) -> None:
        node = self.nodes.pop(kind)
        self.ros._executor.remove_node(node)
        self.ros._nodes.remove(node)
        node.destroy_node()

    def ready(self) -> None:
        self.until(lambda: self.commands.get_subscription_count() > 0 and self.truth and f"/{self.name}" in self.health)
        self.until(lambda: self.health[f"/{self.name}"].level == b"\x00")

    def until(self, condition, timeout: float = 20.0) -> None:
        said = lambda: {name: status.message for name, status in self.health.items()}  # noqa: E731
        assert self.ros.wait_until(condition, timeout), f"waited in vain; {said()}"

    def drive_until(self, condition, **velocity) -> None:
        message = twist(**velocity)
        message = TwistStamped(twist=message) if self.kind is TwistStamped else message
        timer = self.ros.probe.create_timer(0.05, lambda: self.commands.publish(message))
        self.commands.publish(message)
        self.until(condition)
        self.ros.probe.destroy_timer(timer)

    def go_until(self, condition, **velocity) -> None:
        """As `drive_until`, with a person who lets it move, again where a stall of the test has held it."""
        with let_move(self.ros):
            self.drive_until(condition, **velocity)

    def call(self, service: str) -> bool:
        return self.ros.call(Trigger, service).success

    def new_goal(self, planner, status=GoalStatus.STATUS_EXECUTING) -> None:
        """A goal that was not there before, on goal_status, and that the robot has heard of it."""
        message = GoalStatus(status=status)
        message.goal_info.goal_id.uuid = np.frombuffer(uuid.uuid4().bytes, dtype=np.uint8)
        planner.publish(message)
        goal = bytes(bytearray(message.goal_info.goal_id.uuid))
        self.until(lambda: self.nodes[ROBOTS[self.name][0]]._contract._interlock.goals[-1:] == (goal,))

    @property
    def state(self) -> str:
        return next(item.value for item in self.states[-1].values if item.key == "state") if self.states else ""

    def counted(self, key: str) -> int:
        return int(next(item.value for item in self.health[f"/{self.name}"].values if item.key == key))

    def stays_still(self, poses: int, **velocity) -> bool:
        """Whether it stands still for so many poses from now on, commanded or not."""
        now = self.ros.probe.get_clock().now()

        def later() -> list[Odometry]:
            # on a busy machine some that are older have not been taken yet
            return [odometry for odometry in self.truth if Time.from_msg(odometry.header.stamp) > now]

        if velocity:
            self.drive_until(lambda: len(later()) > poses, **velocity)
        else:
            self.until(lambda: len(later()) > poses)
        return all(math.hypot(o.twist.twist.linear.x, o.twist.twist.linear.y) < STANDING for o in later())

    @property
    def velocity(self) -> tuple[float, float]:
        linear = self.truth[-1].twist.twist.linear
        return linear.x, linear.y

    @property
    def speed(self) -> float:
        return math.hypot(*self.velocity)


@pytest.fixture(params=KINDS)
def make_robot(request, ros, tmp_path):
    name, own = request.param
    return lambda **parameters: Robot(ros, tmp_path, name, **own, **parameters)


@pytest.fixture
def robot(make_robot):
    return make_robot()


def test_topics_types_qos_and_services(robot):
    probe = robot.ros.probe
    (taken,) = probe.get_subscriptions_info_by_topic("cmd_vel")
    assert (taken.node_name, taken.topic_type) == (robot.name, "geometry_msgs/msg/Twist")
    assert taken.qos_profile.reliability == ReliabilityPolicy.RELIABLE
    assert taken.qos_profile.durability == DurabilityPolicy.VOLATILE
    (given,) = probe.get_publishers_info_by_topic("mocap/pose")
    assert given.topic_type == "geometry_msgs/msg/PoseStamped"
    assert given.qos_profile.reliability == ReliabilityPolicy.RELIABLE
    assert given.qos_profile.durability == DurabilityPolicy.VOLATILE
    services = dict(probe.get_service_names_and_types())
    for name in ("/estop", "/clear_estop", "/resume", "/reset"):
        assert services[name] == ["std_srvs/srv/Trigger"]
    robot.until(lambda: robot.poses)
    assert robot.poses[-1].header.frame_id == "map"


def test_it_goes_where_it_is_told_in_its_own_frame(robot):
    robot.go_until(lambda: robot.velocity[1] > 0.45, y=0.5)
    assert abs(robot.velocity[0]) < 1e-3
    robot.go_until(lambda: robot.velocity[0] > 0.45, x=0.5)


def test_a_stamped_command_is_taken_where_the_parameter_says_so(make_robot):
    robot = make_robot(**{"controller.stamped_cmd_vel": True})
    robot.go_until(lambda: robot.velocity[0] > 0.3, x=0.4)


def test_zero_is_applied_in_time_after_the_last_command(robot):
    for _ in range(2):
        robot.go_until(lambda: robot.speed > 0.35, x=0.4)
        robot.commands.publish(twist(x=0.4))
        n = len(robot.truth)
        robot.until(lambda: robot.speed < STANDING)
        # poses tell the robot's own time, its stalls left out; braking begins in the period in which zero is applied
        speeds = [o.twist.twist.linear.x for o in robot.truth[n:]]
        braking = next(k for k, speed in enumerate(speeds) if speed < max(speeds) - 0.005)
        assert braking * POSE_PERIOD <= LONGEST + 3 * POSE_PERIOD


@pytest.mark.parametrize(
    "bad", [{"x": math.nan}, {"yaw_rate": math.inf}, {"x": 1.51 * V_MAX}], ids=["nan", "inf", "fast"]
)
def test_a_bad_command_stops_it_and_is_counted(robot, bad):
    robot.go_until(lambda: robot.speed > 0.25, x=0.3)
    robot.drive_until(lambda: robot.speed < STANDING, **bad)
    robot.until(lambda: "refused" in robot.health[f"/{robot.name}"].message)
    assert robot.health[f"/{robot.name}"].level == b"\x01"
    assert robot.counted("refused") > 0


def test_a_command_just_too_fast_is_clipped_with_its_direction_kept(robot):
    robot.go_until(lambda: robot.speed > 0.97 * V_MAX and robot.counted("clipped") > 0, x=1.1 * V_MAX, y=-0.55 * V_MAX)
    assert robot.speed <= V_MAX + 1e-5
    assert robot.velocity[1] / robot.velocity[0] == pytest.approx(-0.5, abs=1e-3)


def test_the_emergency_stop_is_latched(robot):
    robot.go_until(lambda: robot.speed > 0.3, x=0.4)
    assert robot.call("estop")
    robot.drive_until(lambda: robot.speed < STANDING, x=0.4)
    assert robot.stays_still(30, x=0.4)
    robot.until(lambda: "emergency stop" in robot.health[f"/{robot.name}"].message)
    assert robot.health[f"/{robot.name}"].level == b"\x01"
    assert robot.counted("ignored") > 0


def stopped_while_driving(robot) -> None:
    robot.go_until(lambda: robot.speed > 0.3, x=0.4)
    assert robot.call("estop")
    robot.drive_until(lambda: robot.speed < STANDING, x=0.4)
    assert not robot.call("resume"), "not while it is latched"
    assert robot.state == "stopped"
    assert robot.call("clear_estop")


def test_after_the_emergency_stop_no_command_zero_or_not_and_no_silence_moves_it(robot):
    stopped_while_driving(robot)
    robot.until(lambda: robot.state == "held")
    assert robot.stays_still(40, x=0.4)
    assert robot.stays_still(20, x=0.0)
    assert robot.stays_still(20, x=0.4)
    assert robot.stays_still(20, x=math.nan)
    # as a controller does that loses its poses for a moment
    assert robot.stays_still(round((SETTINGS.limits.command_age + 0.1) / POSE_PERIOD))
    assert robot.stays_still(20, x=0.4)
    assert robot.call("clear_estop"), "once more changes nothing"
    assert robot.stays_still(20, x=0.4)
    assert robot.counted("ignored") > 0
    robot.go_until(lambda: robot.speed > 0.3, x=0.4)
    robot.until(lambda: robot.state == "free")


def test_a_new_goal_lets_it_move_and_the_one_of_before_does_not(robot):
    planner = robot.ros.publisher(GoalStatus, "goal_status", LATCHED)
    robot.new_goal(planner)
    assert robot.stays_still(20, x=0.4), "the first goal heard of may be one of before its start"
    robot.new_goal(planner)
    robot.drive_until(lambda: robot.speed > 0.3, x=0.4)
    assert robot.call("estop")
    robot.drive_until(lambda: robot.speed < STANDING, x=0.4)
    robot.new_goal(planner)
    assert robot.call("clear_estop")
    assert robot.stays_still(30, x=0.4), "a goal given during the stop is none given after it"
    robot.new_goal(planner, GoalStatus.STATUS_ABORTED)
    assert robot.stays_still(20, x=0.4), "a goal that was refused"
    robot.new_goal(planner)
    robot.drive_until(lambda: robot.speed > 0.3, x=0.4)


@pytest.mark.parametrize("zero", [False, True])
def test_silence_over_a_second_holds_it_and_shorter_silence_does_not(robot, zero):
    if zero:
        robot.go_until(lambda: robot.speed > 0.3, x=0.4)
    else:
        robot.go_until(lambda: robot.state == "free", x=0.0)
    n = len(robot.truth)
    robot.until(lambda: len(robot.truth) > n + 60)
    robot.drive_until(lambda: robot.speed > 0.3, x=0.4)
    robot.until(lambda: robot.state == "held")
    assert "no fresh command for 1." in robot.states[-1].message
    assert robot.stays_still(40, x=0.4)
    robot.go_until(lambda: robot.speed > 0.3, x=0.4)


def test_who_comes_later_is_told_the_state_it_is_in(robot):
    assert robot.call("estop")
    late = robot.ros.listen(DiagnosticStatus, "robot/state", LATCHED)
    robot.until(lambda: late)
    assert late[0].message == "emergency stop by its service: commands are ignored until it is cleared (clear_estop)"
    assert {item.key: item.value for item in late[0].values}["state"] == "stopped"


def test_its_state_is_said_again_for_who_has_missed_what_is_latched(robot):
    said = robot.ros.listen(DiagnosticStatus, "robot/state", EVENT)
    robot.until(lambda: len(said) > 1)
    assert {message.message for message in said} == {robot.states[-1].message}


def test_a_second_commander_stops_it_and_is_named(robot):
    other = robot.ros.add(rclpy.create_node("teleop", context=robot.ros.context))
    robot.go_until(lambda: robot.speed > 0.3, x=0.4)
    rogue = other.create_publisher(robot.kind, "cmd_vel", NEWEST)
    begun = time.monotonic()
    timer = other.create_timer(0.05, lambda: rogue.publish(twist(y=0.4)))
    robot.drive_until(lambda: robot.state == "held", x=0.4)
    assert time.monotonic() - begun < 0.5
    said = robot.states[-1].message
    assert "2 nodes publish /cmd_vel: /probe, /teleop" in said
    robot.drive_until(lambda: robot.health[f"/{robot.name}"].level == b"\x02", x=0.4)
    assert "/probe, /teleop" in robot.health[f"/{robot.name}"].message
    robot.drive_until(lambda: robot.speed < STANDING, x=0.4)
    assert robot.stays_still(20, x=0.4)
    assert not robot.call("resume")
    other.destroy_timer(timer)
    other.destroy_publisher(rogue)
    robot.until(lambda: robot.call("resume"))
    robot.drive_until(lambda: robot.speed > 0.3, x=0.4)


def test_a_second_commander_of_the_same_name_is_told_by_its_messages(robot):
    robot.go_until(lambda: robot.speed > 0.3, x=0.4)
    rogue = robot.ros.probe.create_publisher(robot.kind, "cmd_vel", NEWEST)
    robot.ros.probe.create_timer(0.03, lambda: rogue.publish(twist(y=0.4)))
    robot.drive_until(lambda: robot.state == "held", x=0.4)
    assert "two publishers of /cmd_vel, both named /probe" in robot.states[-1].message


@pytest.mark.parametrize("restarts", [5, pytest.param(100, marks=[pytest.mark.soak, pytest.mark.timeout(1800)])])
def test_a_commander_that_restarts_is_no_second_one(robot, restarts):
    """Each leaves without a word: its publisher is listed on, as a killed process is until its lease ends."""
    robot.ros.probe.destroy_publisher(robot.commands)
    robot.until(lambda: robot.call("resume"))
    nodes = []
    for _ in range(restarts):
        nodes.append(robot.ros.add(rclpy.create_node("controller_node", context=robot.ros.context)))
        robot.commands = nodes[-1].create_publisher(robot.kind, "cmd_vel", NEWEST)
        if len(nodes) > 3:
            robot.ros.remove(nodes.pop(0))
        n, due = len(robot.truth), time.monotonic() + 0.6 * BREAK_TIME  # three within BREAK_TIME are two publishers
        robot.go_until(lambda n=n, due=due: len(robot.truth) > n + 60 and time.monotonic() > due, x=0.05, y=0.05)
        assert not any("two publishers" in each.message or "nodes publish" in each.message for each in robot.states)


def test_a_command_that_was_long_under_way_is_not_followed(robot, monkeypatch):
    robot.go_until(lambda: robot.speed > 0.1, x=0.2)
    inputs = robot.nodes[ROBOTS[robot.name][0]]._inputs
    delayed = property(lambda self: self._sent - 0.3, lambda self, value: vars(self).update(_sent=value))
    monkeypatch.setattr(type(inputs), "sent", delayed, raising=False)
    robot.drive_until(lambda: robot.speed < STANDING, x=0.2)
    robot.until(lambda: robot.counted("late") > 0)


def test_what_was_queued_in_a_stall_of_the_node_is_dropped(robot):
    robot.go_until(lambda: robot.speed > 0.1, x=0.2)
    contract = robot.nodes[ROBOTS[robot.name][0]]._contract
    for _ in range(10):
        taken, late = contract._commands, contract._late
        robot.commands.publish(twist(x=0.2))
        time.sleep(0.2)  # nothing in this process goes on
        robot.until(lambda late=late: contract._late > late)
        assert contract._commands == taken
    # without a fresh command for over 1 s it may be held by now
    robot.go_until(lambda: contract._commands > taken, x=0.2)


def test_clearing_what_is_not_stopped_changes_nothing(robot):
    robot.go_until(lambda: robot.speed > 0.3, x=0.4)
    assert robot.call("clear_estop")
    robot.go_until(lambda: robot.speed > 0.5, x=0.6)


def test_diagnostics_carry_the_same_figures(robot):
    status = robot.health[f"/{robot.name}"]
    assert {item.key for item in status.values} >= {"commands", "clipped", "refused"}
    assert status.level == b"\x00"


@pytest.mark.parametrize("direction", [-1.0, pytest.param(1.0, marks=pytest.mark.soak)])
def test_an_impact_has_its_sign_and_frame_with_mocap_node_in_the_loop(make_robot, ros, direction):
    told, contacts = ros.listen(Vector3Stamped, "impact", EVENT), ros.listen(PoseStamped, "impact/contact", EVENT)
    robot = make_robot(**{"simulator.noise": 0.1})
    odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    ros.make(MocapNode)
    robot.until(lambda: odometry)
    with let_move(ros):
        robot.drive_until(lambda: 2 * odometry[-1].pose.pose.orientation.z * direction > 1.0, yaw_rate=2.0 * direction)
        robot.drive_until(lambda: abs(robot.truth[-1].twist.twist.angular.z) < STANDING, yaw_rate=0.0)
        yaw = 2 * math.asin(robot.truth[-1].pose.pose.orientation.z)
        # to the wall at x = -1 m, whose push is along x of the map
        robot.drive_until(lambda: told and contacts, x=-0.8 * math.cos(yaw), y=0.8 * math.sin(yaw))
    assert told[0].header.frame_id == "map"
    assert told[0].vector.x > 0.8
    assert abs(told[0].vector.y) < 0.4
    assert contacts[0].pose.position.x == pytest.approx(-1.0, abs=0.03)
    assert contacts[0].header.stamp.sec + 1e-9 * contacts[0].header.stamp.nanosec < (
        told[0].header.stamp.sec + 1e-9 * told[0].header.stamp.nanosec
    )


def test_a_robot_restarted_stands_until_a_person_lets_it_move(robot):
    for kind in ROBOTS[robot.name]:
        robot.go_until(lambda: robot.speed > 0.2, x=0.3)
        robot.end(kind)
        robot.health.clear()
        robot.truth.clear()
        robot.nodes[kind] = robot.start(kind)
        robot.until(lambda: robot.truth and robot.speed < STANDING)
        assert robot.stays_still(30, x=0.3)
        assert robot.stays_still(10, x=0.0)
        assert robot.stays_still(20, x=0.3)
        robot.go_until(lambda: robot.speed > 0.2, x=0.3)


def test_a_robot_restarted_as_a_whole_in_an_emergency_stop_forgets_it_and_is_held(robot):
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)
    assert robot.call("estop")
    robot.until(lambda: robot.state == "stopped")
    kinds = ROBOTS[robot.name]
    for kind in kinds:
        robot.end(kind)
    robot.health.clear()
    robot.truth.clear()
    robot.states.clear()
    robot.nodes = {kind: robot.start(kind) for kind in kinds}
    robot.ready()
    assert robot.state == "held", robot.states[-1].message
    assert robot.stays_still(30, x=0.3)
    assert robot.state == "held", robot.states[-1].message
    robot.go_until(lambda: robot.speed > 0.2, x=0.3)


def test_its_nodes_start_in_any_order(robot):
    kinds = ROBOTS[robot.name]
    for order in (kinds, kinds[::-1]):
        for kind in kinds:
            robot.end(kind)
        robot.health.clear()
        robot.truth.clear()
        for kind in order:
            robot.nodes[kind] = robot.start(kind)
            robot.ros.wait_until(lambda: False, 0.2)
        robot.ready()
        robot.go_until(lambda: robot.speed > 0.2, x=0.3)
