"""Recording of a run: subscribes to every topic of the graph and fills a log, without ever waiting."""

import math
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PointStamped, PoseStamped, Twist, TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry, Path
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String
from trajectory_msgs.msg import MultiDOFJointTrajectory

from collplan_core.parameters import Settings
from collplan_core.scan import ScanError
from collplan_ros.messages.cmd_vel import command_type, twist_of
from collplan_ros.messages.conversions import (
    MessageError,
    impact_contact_from_message,
    impact_from_message,
    scan_from_message,
    state_from_odometry,
)
from collplan_ros.messages.plans import contacts_from_message, plan_from_path
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, LATCHED, SENSOR_DATA
from collplan_ros.runs.run_log import (
    DetectedImpactRecord,
    ImpactRecord,
    PlanRow,
    PoseRow,
    RunLog,
    SentCommand,
    SentManeuver,
    SentReference,
)

# no message may be lost, so the queue bridges a stall of some seconds
EVERY_ONE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.VOLATILE)

FIGURES = ("planning_time_ms", "candidates", "candidates_before_pruning", "hardest_contact")
"""Figures of planner/costs that are recorded."""


class End(NamedTuple):
    """End of a recording: stamp of its last pose, and when that was sent [s]."""

    stamp: float
    sent: float


OPEN, NEVER = End(math.inf, math.inf), End(-math.inf, -math.inf)
"""Recording, and not recording."""


class GoalReport(NamedTuple):
    """The planner's report of a goal: GoalStatus.STATUS_*, and when it was sent [s, wall clock]."""

    status: int
    sent: float


class Recorder:
    """Fills `log` from `begin()` to `finish()`, whole up to the last pose, however late and in whatever order it comes.

    Attributes:
        log: everything recorded.
        reported: newest diagnostics, by the node's full name.
        goal: newest report of the goal given last; None before the first.
        newest: newest pose, also while not recording; None before the first.
        scan_came: whether a valid scan was received.
        lateness: time from sending the newest pose until it was taken here [s]; 0 before the first.
    """

    def __init__(self, node: Node, settings: Settings) -> None:
        """Subscribes through `node`."""
        self.log = RunLog()
        self.reported: dict[str, DiagnosticStatus] = {}
        self.goal: GoalReport | None = None
        self.newest: PoseRow | None = None
        self.scan_came = False
        self.lateness = 0.0
        self._frames = settings.frames
        self._tolerance = settings.planner.goal_tolerance
        self._target = np.full(2, np.nan)
        self._asked = 0.0
        self._end = NEVER
        self._newest_truth = -math.inf
        self._subscribe(node, settings)

    def begin(self) -> None:
        """Starts recording."""
        self._end = OPEN

    def finish(self) -> None:
        """Ends the log with the pose that arrived at the goal, or else with the newest one.

        What is of the time up to that pose and still under way is taken all the same.
        """
        poses, reached = self.log.poses, self.log.reached_sent is not None
        last = self.log.arrival_pose(self._target, self._tolerance, self._asked) if reached else None
        last = last or (poses[-1] if poses else None)
        if last is None:
            self._end = NEVER
            return
        self.log.end_with(last)
        self._end = End(last.stamp, last.sent)

    @property
    def is_complete(self) -> bool:
        """Whether the truth of a simulated robot has come up to the last pose recorded."""
        return not self.log.truth or self._newest_truth >= self._end.stamp

    def ask(self, target: np.ndarray) -> None:
        """Discards reports of earlier goals; to be called before the goal `target` (2,) [m] is given."""
        self.goal = self.log.reached_sent = None
        self._target = target
        self._asked = time.time()

    def _subscribe(self, node: Node, settings: Settings) -> None:
        def listen(kind: type, topic: str, take: Callable[..., None], qos: QoSProfile = EVERY_ONE) -> None:
            node.create_subscription(kind, topic, take, qos)

        listen(DiagnosticArray, "/diagnostics", self._take_diagnostics, DIAGNOSTICS_SUBSCRIBED)
        listen(GoalStatus, "goal_status", self._take_goal_status, LATCHED)
        listen(Odometry, "mocap/odom", self._take_pose)
        listen(Odometry, "ground_truth/odom", self._take_truth)
        listen(Vector3Stamped, "ground_truth/impact", self._take_true_impact)
        listen(PoseStamped, "impact/contact", self._take_detected_impact)
        listen(LaserScan, "scan", self._take_scan, SENSOR_DATA)
        of_the_run = self._of_the_run
        listen(Path, "plan", of_the_run(self._take_plan))
        listen(MultiDOFJointTrajectory, "planner/foreseen_impacts", of_the_run(self._take_contacts))
        listen(DiagnosticArray, "planner/costs", of_the_run(self._take_costs))
        listen(PointStamped, "controller/reference", of_the_run(self._take_reference))
        listen(String, "maneuver", of_the_run(self._take_maneuver), LATCHED)
        listen(command_type(settings), "cmd_vel", of_the_run(self._take_command))

    def _of_the_run(self, take: Callable[[Any, float], None]) -> Callable[[Any, dict[str, Any]], None]:
        # with a second argument rclpy passes the message's info, which holds the time of sending
        def guarded(message: Any, info: dict[str, Any]) -> None:
            sent = _when_sent(info)
            # a message that no node can use is not recorded; the node that drops it counts it
            with suppress(MessageError):
                if sent <= self._end.sent:
                    take(message, sent)

        return guarded

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        self.reported.update({status.name: status for status in message.status})

    def _take_goal_status(self, message: GoalStatus, info: dict[str, Any]) -> None:
        report = GoalReport(message.status, _when_sent(info))
        if report.sent >= self._asked:
            self.goal = report
            self.log.reached_sent = report.sent if report.status == GoalStatus.STATUS_SUCCEEDED else None

    def _take_pose(self, message: Odometry, info: dict[str, Any]) -> None:
        try:
            self.newest = self._pose_row(message)._replace(sent=_when_sent(info))
        except MessageError:
            return
        self.lateness = max(0.0, time.time() - self.newest.sent)
        if self.newest.sent <= self._end.sent:
            self.log.poses.append(self.newest)

    def _take_truth(self, message: Odometry) -> None:
        with suppress(MessageError):
            row = self._pose_row(message)
            self._newest_truth = row.stamp
            if row.stamp <= self._end.stamp:
                self.log.truth.append(row)

    def _take_true_impact(self, message: Vector3Stamped) -> None:
        with suppress(MessageError):
            stamp, change = impact_from_message(message, self._frames.map)
            if stamp <= self._end.stamp:
                self.log.true_impacts.append(ImpactRecord(stamp, *change.tolist()))

    def _take_detected_impact(self, message: PoseStamped) -> None:
        with suppress(MessageError):
            contact = impact_contact_from_message(message, self._frames.map)
            if contact.time <= self._end.stamp:
                place = *contact.point.tolist(), *contact.normal.tolist()
                self.log.detected_impacts.append(DetectedImpactRecord(contact.time, *place))

    def _take_scan(self, message: LaserScan) -> None:
        with suppress(ScanError):
            scan = scan_from_message(message, self._frames.base)
            self.scan_came = True
            if scan.stamp <= self._end.stamp:
                self.log.scans.append(scan)

    def _take_plan(self, message: Path, _: float) -> None:
        plan = plan_from_path(message, self._frames.map)
        self.log.plans.append(PlanRow(plan.stamp, plan.times, plan.positions))

    def _take_contacts(self, message: MultiDOFJointTrajectory, _: float) -> None:
        stamp, contacts = contacts_from_message(message, self._frames.map)
        self.log.contacts[stamp] = contacts

    def _take_costs(self, message: DiagnosticArray, _: float) -> None:
        for status in message.status:
            self.log.costs.append({item.key: float(item.value) for item in status.values if item.key in FIGURES})

    def _take_reference(self, message: PointStamped, sent: float) -> None:
        self.log.sent_references.append(SentReference(sent, message.point.x, message.point.y))

    def _take_maneuver(self, message: String, sent: float) -> None:
        self.log.sent_maneuvers.append(SentManeuver(sent, message.data))

    def _take_command(self, message: Twist | TwistStamped, sent: float) -> None:
        twist = twist_of(message)
        self.log.sent_commands.append(SentCommand(sent, twist.linear.x, twist.linear.y, twist.angular.z))

    def _pose_row(self, message: Odometry) -> PoseRow:
        state = state_from_odometry(message, self._frames.map, self._frames.base)
        (x, y), (vx, vy) = state.position.tolist(), state.velocity.tolist()
        return PoseRow(state.stamp, x, y, state.yaw, vx, vy)


def _when_sent(info: dict[str, Any]) -> float:
    """When the sender passed a message to its middleware [s, wall clock]; delays of the receiver are not in it."""
    return float(1e-9 * info["source_timestamp"])
