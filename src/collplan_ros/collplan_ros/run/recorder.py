"""Monitors a run: keeps the newest reports of its nodes, and marks begin and end in its recording."""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import NamedTuple

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist, TwistStamped
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

from collplan_core.clock_steps import SendTimes
from collplan_core.command import STANDING
from collplan_core.command import STOPPED as STANDS
from collplan_core.movers.coverage import blind_angle
from collplan_core.parameters import Settings
from collplan_core.scan import ScanError
from collplan_core.scans.filters import used_scan
from collplan_ros.messages.raw_reading import BYTES_TOPICS
from collplan_ros.messages.reading import MessageError, scan_from_message, twist_of, velocity_from_twist
from collplan_ros.messages.states import HELD, STOPPED
from collplan_ros.messages.status_values import real_time_factor, values_of
from collplan_ros.node_kit.node_names import full_name, is_in
from collplan_ros.run.description import BEGIN, END, GOAL
from collplan_ros.run.graph_topics import GraphTopics
from collplan_ros.run.run_log import LogBuilder, RunLog, SentPoint


class GoalReport(NamedTuple):
    """The planner's report of a goal: GoalStatus.STATUS_*, and its send time [s, steady clock]."""

    status: int
    sent: float


class Recorder(LogBuilder):
    """The log of a run that is under way, whose begin and end it marks, and the newest reports of the nodes.

    The log is complete up to its end, however late and in any order messages arrive. A message that cannot be read is
    left out; the node that drops it counts it.
    """

    def __init__(
        self,
        topics: GraphTopics,
        settings: Settings,
        mark: Callable[[str, Mapping[str, str]], None],
        times: SendTimes,
        namespace: str = "/",
    ) -> None:
        """Subscribes to `topics`; on topics that robots share, it takes messages of nodes in `namespace` alone.

        `mark` is called with name and values where the run begins or ends and where a goal is given.
        """
        super().__init__(settings)
        self.reported: dict[str, DiagnosticStatus] = {}
        """Newest diagnostics, by the node's full name."""
        self.reported_at: dict[str, float] = {}
        """When these were sent [s, steady clock]."""
        self.goal: GoalReport | None = None
        """Newest report of the goal given last; None before the first."""
        self.robot: dict[str, str] = {}
        """Values of the newest report of the robot, by key."""
        self.emergency_stop = self.robot_held = self.standing = ""
        """Why it is latched; why the robot holds itself; why the controller, held or not, stands or creeps; or ""."""
        self.scan_came, self.scan_refused = False, ""
        """Whether a usable scan has come, and the reason of the newest refusal of one before it."""
        self.blind = 0.0
        """Angle that the first usable scan leaves out [rad]."""
        self.lateness = 0.0
        """Time from sending the newest pose until it was taken here [s]; 0 before the first."""
        self.maneuver = STANDS
        """The newest maneuver."""
        self.stands_since = 0.0
        """When the newest command was sent, if it is zero [s, steady clock]; infinite while one moves."""
        self._mark = mark
        self._times = times
        self._namespace = namespace
        self._base, self._scan_input = settings.frames.base, settings.scan
        self._asked = 0.0
        for topic in self.topics:
            topics.listen(topic, partial(self.take, topic), topic in BYTES_TOPICS)
        self._listen(topics)

    @property
    def real_time_factor(self) -> float | None:
        """Simulated seconds in the last second; None where the robot is not simulated, or in real time."""
        factors = (real_time_factor(values_of(status)) for status in self.reported.values())
        return next((factor for factor in factors if factor is not None), None)

    @property
    def age(self) -> float:
        """Time since the newest pose was sent [s]; infinite before the first."""
        return math.inf if self.newest is None else self._times.now() - self.newest.sent

    def status(self, node: str) -> DiagnosticStatus:
        """Newest diagnostics of a node of this namespace, by its name; empty before the first."""
        return self.reported.get(full_name(self._namespace, node), DiagnosticStatus())

    def silent(self, longest: float) -> dict[str, float]:
        """Time since the newest diagnostics of each node [s], by full name, where it is over `longest` [s]."""
        ages = {name: self._times.now() - sent for name, sent in self.reported_at.items()}
        return {name: age for name, age in ages.items() if age > longest}

    def begin(self, simulated: bool) -> None:
        """Begins the run, or goes on with it; the log so far is dropped, as lap after lap must not fill the memory."""
        self._mark(BEGIN, {"simulated": str(simulated).lower()})
        kept = self._log
        self._log = RunLog(pace=kept.pace, drive=kept.drive, drive_in_words=kept.drive_in_words)
        super().begin(simulated)

    def finish(self) -> None:
        """Ends the run with the pose that arrived at the goal, or else with the newest one.

        Messages of the time up to that pose that are still under way are logged too.
        """
        if self.recording:
            end = self.last
            self._mark(END, {key: repr(value) for key, value in end._asdict().items()})
            self.end(end)

    def ask(self, target: np.ndarray) -> None:
        """Discards reports of earlier goals; to be called before the goal `target` (2,) [m] is given."""
        self.goal = None
        self._asked = self._times.now()
        goal = SentPoint(self._asked, *target.tolist())
        self._mark(GOAL, {key: repr(value) for key, value in goal._asdict().items()})
        self.asked(goal)

    def _listen(self, topics: GraphTopics) -> None:
        topics.listen("/diagnostics", self._hear_diagnostics)
        topics.listen("goal_status", self._hear_goal_status)
        topics.listen("robot/state", self._hear_robot_state)
        topics.listen("controller/state", self._hear_controller_state)
        topics.listen("scan", self._hear_scan)
        topics.listen("maneuver", self._hear_maneuver)
        topics.listen("cmd_vel", self._hear_command)
        # after the log has taken it
        topics.listen("mocap/odom", self._hear_pose, raw=True)

    def _hear_diagnostics(self, message: DiagnosticArray, sent: float) -> None:
        for status in message.status:
            if is_in(self._namespace, status.name):
                self.reported[status.name], self.reported_at[status.name] = status, sent

    def _hear_robot_state(self, message: DiagnosticStatus, _: float) -> None:
        values = self.robot = values_of(message)
        state = values.get("state", "")
        why = message.message or f"emergency stop of {message.name}"
        self.emergency_stop = why if state == STOPPED else ""
        self.robot_held = values.get("reason", message.message) if state == HELD else ""

    def _hear_controller_state(self, message: DiagnosticStatus, _: float) -> None:
        stands = values_of(message).get("maneuver") in STANDING
        self.standing = message.message if stands else ""

    def _hear_goal_status(self, message: GoalStatus, sent: float) -> None:
        if sent >= self._asked:
            self.goal = GoalReport(message.status, sent)

    def _hear_pose(self, _: bytes, sent: float) -> None:
        if self.newest is not None and self.newest.sent == sent:
            self.lateness = max(0.0, self._times.now() - sent)

    def _hear_scan(self, message: LaserScan, _: float) -> None:
        if self.scan_came:
            return
        try:
            scan = used_scan(scan_from_message(message, self._base, self._scan_input), self._scan_input)
            self.scan_came, self.blind = True, blind_angle(scan)
        except ScanError as error:
            self.scan_refused = str(error)

    def _hear_maneuver(self, message: String, _: float) -> None:
        self.maneuver = message.data

    def _hear_command(self, message: Twist | TwistStamped, sent: float) -> None:
        with suppress(MessageError):
            (vx, vy), wz = velocity_from_twist(twist_of(message))
            self.stands_since = math.inf if vx or vy or wz else sent
