"""Record of a run: listens to what its result files are made of and writes it, without ever waiting."""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, NamedTuple, Protocol

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PointStamped, PoseStamped, Twist, TwistStamped, Vector3Stamped
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String
from trajectory_msgs.msg import MultiDOFJointTrajectory

from collplan_core.command import STOPPED
from collplan_core.goal import NO_GOAL
from collplan_core.parameters import Settings
from collplan_core.scan import ScanError
from collplan_core.sensing.scan_filters import used_scan
from collplan_core.state import State
from collplan_ros.messages.cmd_vel import twist_of
from collplan_ros.messages.conversions import (
    check_finite,
    impact_contact_from_message,
    impact_from_message,
    velocity_from_twist,
)
from collplan_ros.messages.goal_status import NAMES
from collplan_ros.messages.lockstep_report import Lockstep, lockstep_of
from collplan_ros.messages.plans import contacts_from_message
from collplan_ros.messages.raw_reading import plan_from_bytes, state_from_bytes
from collplan_ros.messages.reading import scan_from_message
from collplan_ros.messages.status_values import values_of
from collplan_ros.node_kit.node_names import is_in
from collplan_ros.nodes import robot_state
from collplan_ros.runs.record_file import RecordFile
from collplan_ros.runs.run_log import PoseRow
from collplan_ros.runs.run_times import RunTimes, continued
from collplan_ros.runs.send_times import SendTimes

FIGURES = ("planning_time_ms", "candidates", "candidates_before_pruning", "hardest_contact")
"""Figures of planner/costs that are recorded."""

ODD = (ArithmeticError, LookupError, TypeError, ValueError)
"""What a message that nobody expects can raise while it is read."""


class Listening(Protocol):
    """Where messages come from."""

    def listen(self, topic: str, take: Callable[[Any, dict[str, Any]], None], raw: bool = False) -> None:
        """Has each message of a topic, or its bytes, handed to `take`, with what DDS says of it."""


class End(NamedTuple):
    """End of a recording: time of its last pose, and when that was sent [s]."""

    stamp: float
    sent: float


OPEN, NEVER = End(math.inf, math.inf), End(-math.inf, -math.inf)
"""Recording, and not recording."""


class GoalReport(NamedTuple):
    """The planner's report of a goal: GoalStatus.STATUS_*, and when it was sent [s, steady clock]."""

    status: int
    sent: float


class Recorder:
    """Writes from `begin()` on what comes, and keeps the newest of it; `finish()` says where the run ends.

    What is written is whole up to there, however late and in whatever order it comes. A message that cannot be read is
    left out; the node that drops it counts it.

    Attributes:
        reported: newest diagnostics, by the node's full name.
        reported_at: when these were sent [s, steady clock].
        goal: newest report of the goal given last; None before the first.
        newest: newest pose, also while not recording; None before the first.
        emergency_stop: why the robot's emergency stop is latched, in words; empty while it is not.
        held: why the robot is held, in words; empty while it is not.
        standing: why the controller commands the robot to stand, in words; empty while it moves it.
        lockstep: the newest report of how simulated time keeps step with the graph; None where it need not.
        scan_came: whether a scan that can be used was received.
        scan_refused: why the newest scan that cannot be used was refused; empty before one came.
        lateness: time from sending the newest pose until it was taken here [s]; 0 before the first.
        maneuver: the maneuver begun last.
        stands_since: when the newest command was sent, if it is zero [s, steady clock]; infinite while one moves.
        time_zero: time of the first such command, by the newest pose then [s]; None before it.
        n_impacts: number of the true impacts of a simulated robot, else of the detected ones.
    """

    def __init__(
        self,
        topics: Listening,
        settings: Settings,
        record: RecordFile,
        send_times: SendTimes | None = None,
        namespace: str = "/",
    ) -> None:
        """Listens to `topics`, and writes to `record`; what robots share, it takes of nodes in `namespace` alone."""
        self.reported: dict[str, DiagnosticStatus] = {}
        self.reported_at: dict[str, float] = {}
        self.goal: GoalReport | None = None
        self.newest: PoseRow | None = None
        self.emergency_stop = self.held = self.standing = ""
        self.lockstep: Lockstep | None = None
        self.scan_came = False
        self.scan_refused = ""
        self.lateness = 0.0
        self.maneuver = STOPPED
        self.stands_since = 0.0
        self.time_zero: float | None = None
        self._send_times = send_times or SendTimes()
        self._pace = settings.simulator.pace
        self._run_times = RunTimes(self._pace)
        self._record = record
        self._namespace = namespace
        self._frames = settings.frames
        self._scan_input = settings.scan
        self._tolerance = settings.planner.goal_tolerance
        self._target = np.full(2, np.nan)
        self._asked = 0.0
        self._end = NEVER
        self._last: PoseRow | None = None
        self._arrived: PoseRow | None = None
        self._newest_truth: float | None = None
        self._impacts = {"true_impact": 0, "impact": 0}
        self._wall_clock = [(self._send_times.now(), self._send_times.ahead)]
        self._listen(topics)

    @property
    def n_impacts(self) -> int:
        return self._impacts["impact" if self._newest_truth is None else "true_impact"]

    @property
    def age(self) -> float:
        """Time since the newest pose was sent [s]; infinite before the first."""
        return math.inf if self.newest is None else self._send_times.now() - self.newest.sent

    def silent(self, longest: float) -> dict[str, float]:
        """Time since the newest diagnostics of each node [s], by full name, where it is over `longest` [s]."""
        ages = {name: self._send_times.now() - sent for name, sent in self.reported_at.items()}
        return {name: age for name, age in ages.items() if age > longest}

    def begin(self, simulated: bool, goal: np.ndarray) -> None:
        """Starts recording a run to `goal` (2,) [m]."""
        told = {"simulated": simulated, "goal": goal.tolist(), "pace": self._pace, "wall_clock": self._wall_clock}
        self._record.write("run", told)
        self._end = OPEN

    @property
    def recording(self) -> bool:
        """Whether it has begun and is not finished."""
        return self._end == OPEN

    def finish(self) -> None:
        """Ends the run with the pose that arrived at the goal, or else with the newest one.

        What is of the time up to that pose and still under way is written all the same.
        """
        if not self.recording:
            return
        reached = self.goal is not None and self.goal.status == GoalStatus.STATUS_SUCCEEDED
        last = (self._arrived if reached else None) or self._last
        if last is None:
            self._end = NEVER
            return
        self._end = End(last.stamp, last.sent)
        self._record.write("end", *self._end)

    @property
    def is_complete(self) -> bool:
        """Whether the truth of a simulated robot has come up to the last pose recorded."""
        return self._newest_truth is None or self._newest_truth >= self._end.stamp

    def ask(self, target: np.ndarray) -> None:
        """Discards reports of earlier goals; to be called before the goal `target` (2,) [m] is given."""
        self.goal = self._arrived = None
        self._target = target
        self._asked = self._send_times.now()
        self._record.write("asked", self._asked)

    def _listen(self, topics: Listening) -> None:
        def listen(topic: str, take: Callable[[Any, float], None], raw: bool = False) -> None:
            topics.listen(topic, self._guarded(take), raw)

        listen("/diagnostics", self._take_diagnostics)
        listen("goal_status", self._take_goal_status)
        listen("robot/state", self._take_robot_state)
        listen("controller/state", self._take_controller_state)
        listen("mocap/odom", self._take_pose, raw=True)
        listen("ground_truth/odom", self._take_truth, raw=True)
        listen("ground_truth/impact", self._take_true_impact)
        listen("impact/contact", self._take_detected_impact)
        listen("scan", self._take_scan)
        listen("plan", self._take_plan, raw=True)
        listen("planner/foreseen_impacts", self._take_contacts)
        listen("planner/costs", self._take_costs)
        listen("controller/reference", self._take_reference)
        listen("maneuver", self._take_maneuver)
        listen("cmd_vel", self._take_command)

    def _guarded(self, take: Callable[[Any, float], None]) -> Callable[[Any, dict[str, Any]], None]:
        def guarded(message: Any, info: dict[str, Any]) -> None:
            with suppress(*ODD):
                # the sender's middleware stamps it; delays of the receiver are not in it
                take(message, self._sent(1e-9 * info["source_timestamp"]))

        return guarded

    def _sent(self, stamp: float) -> float:
        """When a message with this time of sending [s, wall clock] was sent [s, steady clock]."""
        sent = self._send_times.steady(stamp)
        if self._send_times.ahead != self._wall_clock[-1][1]:
            self._wall_clock.append((self._send_times.now(), self._send_times.ahead))
            if self._end != NEVER:
                self._record.write("wall_clock", *self._wall_clock[-1])
        return sent

    def _write(self, kind: str, sent: float, *entries: object) -> None:
        if sent <= self._end.sent:
            self._record.write(kind, sent, *entries)

    def _time(self, stamp: float) -> float:
        """Time of the run [s] at a stamp of another message than a pose."""
        return continued(stamp, self.newest.stamp if self.newest else stamp, self._run_times.corrections)

    def _take_diagnostics(self, message: DiagnosticArray, sent: float) -> None:
        for status in message.status:
            if not is_in(self._namespace, status.name):
                continue
            before = self.reported.get(status.name)
            if before is None or (before.level, before.message) != (status.level, status.message):
                self._write("health", sent, status.name, status.level[0], status.message)
            self.reported[status.name], self.reported_at[status.name] = status, sent
            self._take_lockstep(values_of(status), sent)

    def _take_robot_state(self, message: DiagnosticStatus, sent: float) -> None:
        values = values_of(message)
        state = values.get("state", "")
        why = message.message or f"emergency stop of {message.name}"
        self.emergency_stop = why if state == robot_state.STOPPED else ""
        self.held = values.get("reason", message.message) if state == robot_state.HELD else ""
        self._write("robot", sent, state, message.message)

    def _take_controller_state(self, message: DiagnosticStatus, _: float) -> None:
        self.standing = message.message if values_of(message).get("activity") == STOPPED else ""

    def _take_lockstep(self, values: Mapping[str, str], sent: float) -> None:
        lockstep = lockstep_of(values)
        if lockstep is None:
            return
        if lockstep.longest_wait > (self.lockstep.longest_wait if self.lockstep else 0.0):
            self._write("waited", sent, lockstep.longest_wait, lockstep.waited_for)
        self.lockstep = lockstep

    def _take_goal_status(self, message: GoalStatus, sent: float) -> None:
        if sent >= self._asked:
            self.goal = GoalReport(message.status, sent)
            self._write("goal", sent, NAMES.get(int(message.status), NO_GOAL))

    def _take_pose(self, raw: bytes, sent: float) -> None:
        state = self._state(raw)
        before = self._run_times.corrections
        (x, y), (vx, vy) = state.position.tolist(), state.velocity.tolist()
        self.newest = pose = PoseRow(self._run_times.of_pose(state.stamp, sent), x, y, state.yaw, vx, vy, sent)
        if self._run_times.corrections is not before:
            self._record.write("clock", self._run_times.corrections)
        self.lateness = max(0.0, self._send_times.now() - sent)
        if sent > self._end.sent:
            return
        self._record.write("pose", *pose)
        self._last = pose
        away = math.hypot(pose.x - self._target[0], pose.y - self._target[1])
        if self._arrived is None and sent >= self._asked and away <= self._tolerance:
            self._arrived = pose

    def _take_truth(self, raw: bytes, sent: float) -> None:
        state = self._state(raw)
        self._newest_truth = self._time(state.stamp)
        if self._newest_truth <= self._end.stamp:
            motion = *state.position.tolist(), state.yaw, *state.velocity.tolist()
            self._record.write("truth", state.stamp, *motion, sent)

    def _take_true_impact(self, message: Vector3Stamped, sent: float) -> None:
        stamp, change = impact_from_message(message, self._frames.map)
        self._take_impact("true_impact", sent, stamp, *change.tolist())

    def _take_detected_impact(self, message: PoseStamped, sent: float) -> None:
        contact = impact_contact_from_message(message, self._frames.map)
        self._take_impact("impact", sent, contact.time, *contact.point.tolist(), *contact.normal.tolist())

    def _take_impact(self, kind: str, sent: float, stamp: float, *entries: float) -> None:
        if self._time(stamp) <= self._end.stamp:
            self._impacts[kind] += 1
            self._record.write(kind, sent, stamp, *entries)

    def _take_scan(self, message: LaserScan, sent: float) -> None:
        try:
            scan = scan_from_message(message, self._frames.base, self._scan_input)
        except ScanError as error:
            self.scan_refused = str(error)
            raise
        # as came it is recorded, but one of which nothing is used could not be shown
        used_scan(scan, self._scan_input)
        self.scan_came = True
        limits = (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max, scan.time_increment)
        self._write("scan", sent, scan.stamp, *limits, scan.ranges.round(4).tolist())

    def _take_plan(self, raw: bytes, sent: float) -> None:
        plan = plan_from_bytes(raw, self._frames.map)
        self._write("plan", sent, plan.stamp, plan.times.tolist(), plan.positions.round(5).tolist())

    def _take_contacts(self, message: MultiDOFJointTrajectory, sent: float) -> None:
        stamp, contacts = contacts_from_message(message, self._frames.map)
        vectors = contacts.points.tolist(), contacts.velocities_after.tolist()
        self._write("contacts", sent, stamp, contacts.times.tolist(), *vectors)

    def _take_costs(self, message: DiagnosticArray, sent: float) -> None:
        for status in message.status:
            figures = {item.key: float(item.value) for item in status.values if item.key in FIGURES}
            check_finite("planner/costs", *figures.values())
            self._write("costs", sent, figures)

    def _take_reference(self, message: PointStamped, sent: float) -> None:
        point = float(message.point.x), float(message.point.y)
        check_finite("controller/reference", *point)
        self._write("reference", sent, *point)

    def _take_maneuver(self, message: String, sent: float) -> None:
        # a text that is no Unicode could not be written to a file
        self.maneuver = message.data.encode(errors="replace").decode()
        self._write("maneuver", sent, self.maneuver)

    def _take_command(self, message: Twist | TwistStamped, sent: float) -> None:
        (vx, vy), wz = velocity_from_twist(twist_of(message))
        moves = bool(vx or vy or wz)
        self.stands_since = math.inf if moves else sent
        if moves and self.time_zero is None and self.newest is not None and self.recording:
            self.time_zero = self.newest.stamp + self._pace * (sent - self.newest.sent)
        self._write("command", sent, float(vx), float(vy), wz)

    def _state(self, raw: bytes) -> State:
        return state_from_bytes(raw, self._frames.map, self._frames.base)
