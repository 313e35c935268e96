"""controller_node alone, with a fake robot that stands in a hall and a fake planner."""

import math
import signal
import subprocess
import sys
import time
import uuid

import numpy as np
import pytest
import rclpy
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PointStamped, Twist, TwistStamped
from nav_msgs.msg import Path
from rclpy.parameter import Parameter
from std_msgs.msg import Empty, String
from trajectory_msgs.msg import MultiDOFJointTrajectory

from collplan_core.goal import EXECUTING, Goal
from collplan_core.plan import Candidates, Contacts, Plan
from collplan_ros.messages.conversions import stamp_from_seconds
from collplan_ros.messages.goal_status import NAMES, goal_to_status
from collplan_ros.messages.plans import contacts_to_message, plan_to_path
from collplan_ros.messages.qos import (
    CONSTANTS_PUBLISHED,
    DIAGNOSTICS_SUBSCRIBED,
    EVENT,
    LATCHED,
    NEWEST,
    POSE_PUBLISHED,
)
from collplan_ros.nodes.controller_node import ControllerNode
from fake_robot import FakeRobot, hall

YAW = 0.7
SPEED = 0.5
STALL = 0.3
"""Longer than what a node lets pass as running [s]."""


def straight_plan(stamp: float, start: np.ndarray, duration: float = 2.0) -> Plan:
    """Along x at SPEED."""
    times = stamp + np.linspace(0.0, duration, 21)
    positions = start + np.column_stack([SPEED * (times - stamp), np.zeros(21)])
    nothing = Candidates(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    velocities = np.tile([SPEED, 0.0], (21, 1))
    return Plan(stamp, times, positions, velocities, Contacts.none(), positions[-1], velocities[-1], {}, nothing, 0)


class ControllerBench:
    """The node, a robot and a planner for it, and everything it says."""

    def __init__(self, ros, **parameters):
        self.ros = ros
        overrides = {k.replace("__", "."): v for k, v in parameters.items()}
        twist = TwistStamped if overrides.get("controller.stamped_cmd_vel") else Twist
        self.commands = ros.listen(twist, "cmd_vel", EVENT)
        self.references = ros.listen(PointStamped, "controller/reference", EVENT)
        self.maneuvers = ros.listen(String, "maneuver", LATCHED)
        self.states = ros.listen(DiagnosticStatus, "controller/state", LATCHED)
        self.reports = ros.listen(DiagnosticArray, "/diagnostics", DIAGNOSTICS_SUBSCRIBED)
        self.robot = FakeRobot(ros, hall(), YAW)
        self.node = ros.make(ControllerNode, overrides)
        self.plans = ros.publisher(Path, "plan", NEWEST)
        self.statuses = ros.publisher(GoalStatus, "goal_status", LATCHED)
        self.goal = self.new_goal(self.robot.stamp)
        assert ros.wait_until(lambda: self.node._loop._sensors.scan_stamp is not None and self.commands)

    @staticmethod
    def new_goal(stamp, status=EXECUTING) -> Goal:
        return Goal(uuid.uuid4().bytes, stamp, np.full(2, math.nan), status)

    def send_status(self, status=GoalStatus.STATUS_EXECUTING, stamp=None):
        self.goal = self.new_goal(self.robot.stamp if stamp is None else stamp, NAMES[status])
        self.statuses.publish(goal_to_status(self.goal))
        assert self.ros.wait_until(lambda: self.node._loop.goal is not None and self.node._loop.goal.id == self.goal.id)

    def path(self, **changes) -> Path:
        """A plan of the newest scan that the node has."""
        return plan_to_path(straight_plan(self.node._loop._sensors.scan_stamp, self.robot.position, **changes), "map")

    def wait_for_scan(self):
        """Until the node has a scan that is later than the goal."""
        assert self.ros.wait_until(lambda: (self.node._loop._sensors.scan_stamp or 0.0) > self.goal.stamp + 1e-6)

    def drive(self):
        """A goal and plans for it, until the robot is told to move."""
        self.send_status()
        self.wait_for_scan()
        self.plans.publish(self.path())
        assert self.ros.wait_until(self.moves)

    def moves(self):
        return self.commands and is_moving(self.commands[-1])

    def wait_until_still(self, reason):
        """Zero commands, and the health that says why."""
        assert self.ros.wait_until(lambda: not self.moves())
        assert self.ros.wait_until(lambda: reason in self.health().message)
        assert self.maneuvers[-1].data == "stopped"

    def health(self) -> DiagnosticStatus:
        """The newest health, asked for now."""
        before = len(self.reports)
        self.node._diagnostics.publish()
        assert self.ros.wait_until(lambda: len(self.reports) > before)
        return self.reports[-1].status[0]

    def values(self):
        return {v.key: v.value for v in self.health().values}


def robot_state(name: str, reason: str = "") -> DiagnosticStatus:
    """As a robot says it on robot/state."""
    message = f"{name}, {reason}: give a new goal, or call resume" if reason else ""
    values = [KeyValue(key="state", value=name), KeyValue(key="reason", value=reason)]
    return DiagnosticStatus(name="/driver_node", message=message, values=values)


def is_moving(command) -> bool:
    twist = getattr(command, "twist", command)
    return twist.linear.x != 0.0 or twist.linear.y != 0.0 or twist.angular.z != 0.0


@pytest.fixture
def bench(ros):
    return ControllerBench(ros)


def test_follows_a_plan_in_the_robot_frame(ros, bench):
    bench.drive()
    assert ros.wait_until(lambda: bench.references and bench.maneuvers[-1].data == "free_space")
    first = next(c for c in bench.commands if is_moving(c))
    forward = math.hypot(first.linear.x, first.linear.y)
    assert 0.8 * SPEED < forward <= 1.2
    assert math.atan2(first.linear.y, first.linear.x) == pytest.approx(-YAW, abs=0.05)
    reference = bench.references[0]
    assert reference.header.frame_id == "map"
    assert 0.0 <= reference.point.x <= 2.0 * SPEED
    assert reference.point.y == pytest.approx(0.0, abs=1e-9)
    assert bench.health().message == "moving"


def test_commands_zero_from_the_start_and_says_why(ros, bench):
    assert ros.wait_until(lambda: len(bench.commands) > 3)
    bench.wait_until_still("no active goal")
    bench.send_status()
    bench.wait_until_still("no plan yet")
    assert bench.health().level == DiagnosticStatus.WARN
    assert not any(is_moving(command) for command in bench.commands)


def test_stands_still_when_plans_stop(ros, bench):
    bench.drive()
    bench.wait_until_still("plan 0.")


def test_stands_still_when_poses_stop(ros, bench):
    bench.node.set_parameters([Parameter("limits.plan_age", value=2.0)])
    bench.drive()
    bench.robot.poses_on = False
    bench.wait_until_still("pose 0.")


def test_poses_lost_for_over_a_second_hold_it_until_the_robot_says_that_a_person_resumed(ros, bench):
    resumed = ros.publisher(Empty, "robot/resumed", EVENT)
    bench.drive()
    bench.robot.poses_on = False
    bench.wait_until_still("held: pose ")
    bench.robot.poses_on = True
    ros.probe.create_timer(
        0.05, lambda: bench.node._loop._sensors.scan_stamp is not None and bench.plans.publish(bench.path())
    )
    n = len(bench.commands)
    assert ros.wait_until(lambda: len(bench.commands) > n + 10)
    assert not any(is_moving(command) for command in bench.commands[n:])
    assert bench.values()["held"].startswith("pose ")
    resumed.publish(Empty())
    assert ros.wait_until(bench.moves)


def test_a_robot_that_holds_itself_is_said_to_be_held_once(ros, bench):
    states = ros.publisher(DiagnosticStatus, "robot/state", LATCHED)
    bench.drive()
    states.publish(robot_state("held", "no fresh command for 1.1 s"))
    expected = "stands still: held: no fresh command for 1.1 s; give a new goal, or call resume"
    assert ros.wait_until(lambda: bench.states[-1].message == expected), bench.states[-1].message


def test_what_the_robot_says_while_the_node_is_frozen_is_heard_after(ros, bench):
    states = ros.publisher(DiagnosticStatus, "robot/state", LATCHED)
    bench.drive()
    ros.probe.create_timer(0.05, lambda: bench.plans.publish(bench.path()))
    states.publish(robot_state("held", "no fresh command for 1.1 s"))
    time.sleep(STALL)
    bench.wait_until_still("no fresh command for 1.1 s")
    states.publish(robot_state("free"))
    time.sleep(STALL)
    assert ros.wait_until(bench.moves)


def test_stands_still_when_scans_stop(ros, bench):
    bench.node.set_parameters([Parameter("limits.plan_age", value=2.0)])
    bench.drive()
    bench.robot.scans_on = False
    bench.wait_until_still("scan 0.")


def test_bad_scans_and_poses_are_counted_and_stop_the_robot(ros, bench):
    bench.node.set_parameters([Parameter("limits.plan_age", value=2.0)])
    bench.drive()
    bench.robot.scans_on = bench.robot.poses_on = False
    for pose in bench.robot.bad_poses():
        bench.robot.poses.publish(pose)
    for scan in bench.robot.bad_scans():
        bench.robot.scans.publish(scan)
        ros.spin(0.02)
    assert ros.wait_until(lambda: (bench.node._loop.refusals["pose"], bench.node._loop.refusals["scan"]) == (3, 6))
    bench.wait_until_still("pose refused: orientation")


def test_refused_poses_stop_the_robot_before_the_last_one_is_old(ros, bench):
    bench.node.set_parameters([Parameter("limits.plan_age", value=2.0), Parameter("limits.pose_age", value=0.5)])
    refusals = ros.publisher(String, "mocap/refused", POSE_PUBLISHED)
    bench.drive()
    bench.robot.poses_on = False
    refusals.publish(String(data="yaw: pose 0.0, 0.0, 0.1, yaw 3.14, tilt 0.00 at 101.00"))
    bench.wait_until_still("pose refused: yaw")
    bench.robot.poses_on = True
    bench.plans.publish(bench.path())
    assert ros.wait_until(bench.moves)


def test_a_planner_that_begins_anew_without_a_goal_stops(bench):
    bench.drive()
    bench.statuses.publish(GoalStatus(status=GoalStatus.STATUS_UNKNOWN))
    bench.wait_until_still("no active goal")


@pytest.mark.parametrize("status", [GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED])
def test_end_of_the_goal_stops(ros, bench, status):
    bench.drive()
    bench.send_status(status)
    bench.wait_until_still("no active goal")
    before = len(bench.commands)
    bench.plans.publish(bench.path())
    assert ros.wait_until(lambda: bench.node._loop.refusals["plan"] == 1 and len(bench.commands) > before + 3)
    assert not any(is_moving(command) for command in bench.commands[before:])


def test_new_goal_drops_the_plan_of_the_old(ros, bench):
    bench.drive()
    old = bench.path()
    bench.send_status(stamp=bench.robot.stamp)
    bench.wait_until_still("no plan yet")
    bench.plans.publish(old)
    assert ros.wait_until(lambda: bench.node._loop.refusals["plan"] == 1)
    bench.wait_for_scan()
    bench.plans.publish(bench.path())
    assert ros.wait_until(bench.moves)


def empty(path):
    path.poses = []


def not_a_number(path):
    path.poses[3].pose.position.x = math.nan


def infinite(path):
    path.poses[-1].pose.position.y = math.inf


def past(path):
    for pose in path.poses:
        pose.header.stamp.sec -= 10


def not_rising(path):
    path.poses[5].header.stamp = path.poses[4].header.stamp


def other_frame(path):
    path.header.frame_id = "odom"


def of_another_goal(path):
    path.header.stamp = stamp_from_seconds(50.0)


BAD_PATHS = (empty, not_a_number, infinite, past, not_rising, other_frame, of_another_goal)


def test_bad_paths_are_counted_and_never_move_the_robot(ros, bench):
    bench.send_status()
    bench.wait_for_scan()
    for count, spoil in enumerate(BAD_PATHS, 1):
        path = bench.path()
        spoil(path)
        bench.plans.publish(path)
        assert ros.wait_until(lambda n=count: bench.node._loop.refusals["plan"] == n), spoil.__name__
    before = len(bench.commands)
    assert ros.wait_until(lambda: len(bench.commands) > before + 3)
    assert not any(is_moving(command) for command in bench.commands)
    assert bench.values()["refused_plan"] == str(len(BAD_PATHS))


def test_plan_waits_for_the_pose_that_it_begins_at(ros, bench):
    bench.send_status()
    bench.wait_for_scan()
    coming = bench.node._loop._sensors.state.stamp + 0.1
    bench.plans.publish(plan_to_path(straight_plan(coming, bench.robot.position), "map"))
    assert ros.wait_until(lambda: bench.node._loop._waiting is not None)
    assert ros.wait_until(bench.moves)
    assert bench.node._loop._sensors.state.stamp >= coming - 1e-6


def test_plan_of_the_future_is_refused(ros, bench):
    bench.send_status()
    bench.wait_for_scan()
    bench.plans.publish(plan_to_path(straight_plan(900.0, bench.robot.position), "map"))
    assert ros.wait_until(lambda: bench.node._loop.refusals["plan"] == 1)
    assert "begins at 900.000" in bench.values()["last_refusal"]
    assert not any(is_moving(command) for command in bench.commands)


def test_leap_of_the_poses_drops_the_plan(ros, bench):
    bench.drive()
    bench.robot.position = np.array([1.0, 0.5])
    assert ros.wait_until(lambda: bench.node._loop.refusals["pose_break"] >= 1)
    bench.wait_until_still("no plan yet")


def plan_at(bench, stamp):
    return plan_to_path(straight_plan(stamp, bench.robot.position), "map")


def pose_without_scan(bench):
    """The stamp of a pose that came with no scan."""
    assert bench.ros.wait_until(
        lambda: bench.node._loop._sensors.state.stamp > (bench.node._loop._sensors.scan_stamp or 0.0) + 1e-6
    )
    return bench.node._loop._sensors.state.stamp


def test_a_plan_is_followed_without_a_scan_of_its_stamp(ros, bench):
    bench.send_status(stamp=99.0)
    bench.plans.publish(plan_at(bench, pose_without_scan(bench)))
    assert ros.wait_until(bench.moves)
    first = next(c for c in bench.commands if is_moving(c))
    assert 0.5 * SPEED < math.hypot(first.linear.x, first.linear.y) <= 1.2
    assert math.atan2(first.linear.y, first.linear.x) == pytest.approx(-YAW, abs=0.05)
    bench.wait_until_still("plan ")


def test_a_plan_of_before_a_leap_of_the_poses_is_not_followed(ros, bench):
    bench.send_status(stamp=99.0)
    before = plan_at(bench, pose_without_scan(bench))
    bench.robot.position = np.array([1.0, 0.5])
    assert ros.wait_until(lambda: bench.node._loop.refusals["pose_break"] >= 1)
    bench.plans.publish(before)
    assert ros.wait_until(lambda: bench.node._loop._waiting is not None)
    heard = len(bench.commands)
    assert ros.wait_until(lambda: len(bench.commands) > heard + 3)
    assert not any(is_moving(command) for command in bench.commands)


def test_stamped_commands(ros):
    bench = ControllerBench(ros, controller__stamped_cmd_vel=True)
    bench.drive()
    first = next(c for c in bench.commands if is_moving(c))
    assert first.header.frame_id == "base_link"
    assert first.header.stamp.sec >= 100


def test_live_parameters_work_in_the_next_period_and_bad_ones_say_why(ros, bench):
    bench.drive()
    slow, negative, fixed = bench.node.set_parameters(
        [
            Parameter("robot.max_speed", value=0.1),
            Parameter("controller.k_p", value=-1.0),
            Parameter("controller.rate", value=50.0),
        ]
    )
    assert slow.successful
    assert "controller.k_p" in negative.reason
    assert not fixed.successful
    before = len(bench.commands)
    bench.plans.publish(bench.path())
    assert ros.wait_until(lambda: len(bench.commands) > before + 3)
    later = bench.commands[before + 1 :]
    assert all(math.hypot(c.linear.x, c.linear.y) <= 0.1 + 1e-9 for c in later)


def test_control_period_is_reported(ros, bench):
    assert ros.wait_until(lambda: int(bench.values()["control_period_ms.n"]) >= 5)
    values = bench.values()
    assert 0.0 < float(values["control_period_ms.p50"]) <= float(values["control_period_ms.p99"])


def disagreeing(name: str) -> DiagnosticStatus:
    return DiagnosticStatus(name=name, message="another hash", values=[KeyValue(key="robot.radius", value="0.15")])


def test_stands_still_where_constants_differ_and_names_the_key(ros, bench):
    bench.drive()
    others = ros.publisher(DiagnosticStatus, "shared_constants", CONSTANTS_PUBLISHED)
    others.publish(disagreeing("/driver_node"))
    reason = "robot.radius: 0.09 here, 0.15 in /driver_node"
    bench.wait_until_still(reason)
    assert bench.states[-1].message == f"stands still: {reason}"


def test_a_goal_makes_a_warning_of_a_reason_that_stays_the_same(ros, bench):
    ros.publisher(DiagnosticStatus, "shared_constants", CONSTANTS_PUBLISHED).publish(disagreeing("/driver_node"))
    reason = "stands still: robot.radius: 0.09 here, 0.15 in /driver_node"
    assert ros.wait_until(lambda: bench.states and bench.states[-1].message == reason)
    assert bench.states[-1].level == DiagnosticStatus.OK
    bench.send_status()
    assert ros.wait_until(lambda: bench.states[-1].level == DiagnosticStatus.WARN)
    assert bench.states[-1].message == reason


def test_the_state_says_what_it_does_and_why(ros, bench):
    bench.drive()
    assert ros.wait_until(lambda: bench.states and bench.states[-1].message == "follows the plan")
    bench.robot.poses_on = False
    assert ros.wait_until(lambda: bench.states[-1].message.startswith("stands still: pose 0."))
    assert bench.states[-1].level == DiagnosticStatus.WARN
    bench.robot.poses_on = True
    bench.send_status(GoalStatus.STATUS_CANCELED)
    assert ros.wait_until(lambda: bench.states[-1].message == "stands still: no active goal")
    assert bench.states[-1].level == DiagnosticStatus.OK


def test_a_contact_foreseen_for_now_is_a_bounce(ros, bench):
    bench.drive()
    contacts = ros.publisher(MultiDOFJointTrajectory, "planner/foreseen_impacts", EVENT)
    plan = straight_plan(bench.node._loop._sensors.scan_stamp, bench.robot.position)
    foreseen = Contacts(np.array([plan.stamp + 0.1]), np.array([[0.3, 0.2]]), np.array([[-0.2, 0.0]]))
    contacts.publish(contacts_to_message(foreseen, plan.stamp, "map", "base_link"))
    bench.plans.publish(plan_to_path(plan, "map"))
    bounces = "bounces off the boundary at 0.30, 0.20"
    assert ros.wait_until(lambda: bounces in [state.message for state in bench.states])


def test_it_knows_no_world(bench):
    assert not [name for name in bench.node._parameters if "world" in name]


def test_stop_commands_zero(ros, bench):
    bench.drive()
    ros.spin(0.02)
    bench.node.stop()
    last = len(bench.commands)
    assert ros.wait_until(lambda: len(bench.commands) > last)
    assert not is_moving(bench.commands[last])


def started(module):
    code = f"import sys; from collplan_ros.nodes.{module} import main; sys.exit(main())"
    return subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True)


def test_processes_end_clean_on_a_signal(ros):
    commands = ros.listen(Twist, "cmd_vel", EVENT)
    reports = ros.listen(DiagnosticArray, "/diagnostics", DIAGNOSTICS_SUBSCRIBED)
    processes = {"controller_node": signal.SIGINT, "planner_node": signal.SIGTERM}
    running = {started(module): number for module, number in processes.items()}
    try:
        assert ros.wait_until(lambda: len({r.status[0].name for r in reports}) == 2 and commands, timeout=100.0)
        for process, number in running.items():
            process.send_signal(number)
        assert ros.wait_until(lambda: all(process.poll() is not None for process in running))
    finally:
        for process in running:
            process.kill()
        errors = [process.communicate()[1] for process in running]
    assert [process.returncode for process in running] == [0, 0], errors
    assert not [error for error in errors if "Traceback" in error]
    assert not any(is_moving(command) for command in commands)


class Hand:
    """A person's commands, 50 a second while the test waits."""

    def __init__(self, bench, topic="hand/cmd_vel") -> None:
        self.sent = None
        self.publisher = bench.ros.publisher(Twist, topic, NEWEST)
        bench.ros.probe.create_timer(0.02, lambda: self.sent and self.publisher.publish(self.sent))

    def drives(self, x: float, y: float) -> None:
        self.sent = Twist()
        self.sent.linear.x, self.sent.linear.y = x, y

    def lets_go(self) -> None:
        """As teleop_node does: zero once, then nothing."""
        self.sent = None
        self.publisher.publish(Twist())


def test_a_hand_drives_before_the_planner_and_gives_back_by_resume(ros, bench):
    resumed = ros.publisher(Empty, "robot/resumed", EVENT)
    hand = Hand(bench)
    bench.drive()
    ros.probe.create_timer(0.05, lambda: bench.plans.publish(bench.path()))
    hand.drives(-0.2, 0.0)
    assert ros.wait_until(lambda: bench.commands[-1].linear.x == pytest.approx(-0.2))
    assert bench.maneuvers[-1].data == "hand"
    assert bench.states[-1].message == "is driven by hand"
    assert bench.health().message == "driven by hand"
    references = len(bench.references)
    ros.spin(0.1)
    assert len(bench.references) == references
    hand.lets_go()
    bench.wait_until_still("held: driven by hand; give a new goal, or call resume")
    resumed.publish(Empty())
    assert ros.wait_until(bench.moves)


def test_a_hand_that_is_slowed_or_refused_is_a_warning_and_one_that_dies_stops_the_robot(ros, bench):
    def warned(state: str, health: str) -> bool:
        """Whether state and health begin so; the health is a warning."""
        said = bench.health()
        return bench.states[-1].message.startswith(state) and (said.level, said.message[: len(health)]) == (
            DiagnosticStatus.WARN,
            health,
        )

    hand = Hand(bench)
    hand.drives(0.0, 0.2)
    assert ros.wait_until(bench.moves)
    bench.robot.poses_on = False
    assert ros.wait_until(lambda: warned("is driven by hand, slowly: pose ", "driven by hand, slowly: pose "))
    hand.drives(math.nan, 0.2)
    assert ros.wait_until(lambda: warned("stands still: by hand: got nan", "standing still: by hand: got nan"))
    assert bench.states[-1].level == DiagnosticStatus.WARN
    hand.drives(0.0, 0.2)
    assert ros.wait_until(bench.moves)
    hand.sent = None
    assert ros.wait_until(lambda: not bench.moves())
    health = bench.health()
    assert (health.level, health.message) == (DiagnosticStatus.OK, "standing still: no active goal")


def test_two_hands_stop_the_robot_and_are_named(ros, bench):
    hand = Hand(bench)
    hand.drives(0.0, 0.2)
    assert ros.wait_until(bench.moves)
    other = ros.add(rclpy.create_node("other_hand", context=ros.context))
    other.create_publisher(Twist, "hand/cmd_vel", NEWEST)
    assert ros.wait_until(lambda: not bench.moves())
    expected = "2 nodes publish /hand/cmd_vel: /other_hand, /probe; end all but one"
    assert expected in bench.health().message
    ros.remove(other)
    assert ros.wait_until(bench.moves)
