"""Monitors a run: keeps the newest reports of its nodes, and marks begin and end in its recording."""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, NamedTuple, Protocol

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist, TwistStamped
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

from collplan_core.clock_steps import SendTimes
from collplan_core.command import STANDING
from collplan_core.command import STOPPED as STANDS
from collplan_core.loop.mover_guard import OUT_OF_VIEW
from collplan_core.movers.coverage import blind_angle
from collplan_core.parameters import Settings
from collplan_core.scan import ScanError
from collplan_core.sensing.scan_filters import used_scan
from collplan_ros.messages.raw_reading import BYTES_TOPICS
from collplan_ros.messages.reading import MessageError, scan_from_message, twist_of, velocity_from_twist
from collplan_ros.messages.states import HELD, STOPPED
from collplan_ros.messages.status_values import real_time_factor, values_of
from collplan_ros.node_kit.node_names import full_name, is_in
from collplan_ros.run.description import BEGIN, END, GOAL
from collplan_ros.run.log_builder import LogBuilder
from collplan_ros.run.run_log import PoseRow, SentGoal


class Listening(Protocol):
    """Source of the messages to record."""

    def listen(self, topic: str, take: Callable[[Any, float], None], raw: bool = False) -> None:
        """Hands each message of a topic, or its bytes, to `take`, with its send time [s, steady clock]."""


class GoalReport(NamedTuple):
    """The planner's report of a goal: GoalStatus.STATUS_*, and its send time [s, steady clock]."""

    status: int
    sent: float


class Recorder:
    """Logs messages from `begin()` on, and keeps the newest ones; `finish()` sets the end of the run.

    The log is complete up to there, however late and in any order messages arrive. A message that cannot be read is
    left out; the node that drops it counts it.

    Attributes:
        reported: newest diagnostics, by the node's full name.
        reported_at: send times of these [s, steady clock].
        goal: newest report of the goal given last; None before the first.
        robot: values of the newest report of the robot, by key.
        emergency_stop: reason why the robot's emergency stop is latched; empty while it is not.
        held: reason why the robot is held; empty while it is not.
        standing: reason why the controller commands the robot to stand, or to creep; empty while it moves it.
        scan_came: whether a usable scan was received.
        blind: angle that the first usable scan leaves out [rad].
        scan_refused: reason of the newest refusal of a scan; empty before the first.
        lateness: time from sending the newest pose until it was taken here [s]; 0 before the first.
        maneuver: the newest maneuver.
        stands_since: send time of the newest command, if it is zero [s, steady clock]; infinite while one moves.
    """

    def __init__(
        self,
        topics: Listening,
        settings: Settings,
        mark: Callable[[str, Mapping[str, str]], None],
        times: SendTimes,
        namespace: str = "/",
    ) -> None:
        """Subscribes to `topics`; on topics that robots share, it takes messages of nodes in `namespace` alone.

        `mark` is called with name and values where the run begins or ends and where a goal is given.
        """
        self.reported: dict[str, DiagnosticStatus] = {}
        self.reported_at: dict[str, float] = {}
        self.goal: GoalReport | None = None
        self.robot: dict[str, str] = {}
        self.emergency_stop = self.held = self.standing = ""
        self.scan_came, self.blind = False, 0.0
        self.scan_refused = ""
        self.lateness = 0.0
        self.maneuver = STANDS
        self.stands_since = 0.0
        self._builder = LogBuilder(settings)
        self._mark = mark
        self._times = times
        self._namespace = namespace
        self._base, self._scan_input = settings.frames.base, settings.scan
        self._asked = 0.0
        for topic in self._builder.topics:
            topics.listen(topic, partial(self._builder.take, topic), topic in BYTES_TOPICS)
        self._listen(topics)

    @property
    def newest(self) -> PoseRow | None:
        """Newest pose, also while not recording; None before the first."""
        return self._builder.newest

    @property
    def real_time_factor(self) -> float | None:
        """Simulated seconds in the last second; None where the robot is not simulated, or in real time."""
        factors = (real_time_factor(values_of(status)) for status in self.reported.values())
        return next((factor for factor in factors if factor is not None), None)

    @property
    def time_zero(self) -> float | None:
        """Time of the first command to move, by the newest pose then [s]; None before it."""
        return self._builder.time_zero

    @property
    def n_impacts(self) -> int:
        """Number of the true impacts of a simulated robot, else of the detected ones."""
        return self._builder.n_impacts

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
        """Begins the run, or goes on with it."""
        self._builder.drop()
        self._mark(BEGIN, {"simulated": str(simulated).lower()})
        self._builder.begin(simulated)

    @property
    def recording(self) -> bool:
        """True where it has begun and is not finished."""
        return self._builder.is_open

    def finish(self) -> None:
        """Ends the run with the pose that arrived at the goal, or else with the newest one.

        Messages of the time up to that pose that are still under way are logged too.
        """
        if not self.recording:
            return
        end = self._builder.last
        self._mark(END, {key: repr(value) for key, value in end._asdict().items()})
        self._builder.end(end)

    @property
    def is_complete(self) -> bool:
        """True where the truth of a simulated robot has come up to the last pose recorded."""
        return self._builder.is_complete

    def ask(self, target: np.ndarray) -> None:
        """Discards reports of earlier goals; to be called before the goal `target` (2,) [m] is given."""
        self.goal = None
        self._asked = self._times.now()
        goal = SentGoal(self._asked, *target.tolist())
        self._mark(GOAL, {key: repr(value) for key, value in goal._asdict().items()})
        self._builder.ask(goal)

    def _listen(self, topics: Listening) -> None:
        topics.listen("/diagnostics", self._take_diagnostics)
        topics.listen("goal_status", self._take_goal_status)
        topics.listen("robot/state", self._take_robot_state)
        topics.listen("controller/state", self._take_controller_state)
        topics.listen("scan", self._take_scan)
        topics.listen("maneuver", self._take_maneuver)
        topics.listen("cmd_vel", self._take_command)
        # after the log has taken it
        topics.listen("mocap/odom", self._take_pose, raw=True)

    def _take_diagnostics(self, message: DiagnosticArray, sent: float) -> None:
        for status in message.status:
            if is_in(self._namespace, status.name):
                self.reported[status.name], self.reported_at[status.name] = status, sent

    def _take_robot_state(self, message: DiagnosticStatus, _: float) -> None:
        values = self.robot = values_of(message)
        state = values.get("state", "")
        why = message.message or f"emergency stop of {message.name}"
        self.emergency_stop = why if state == STOPPED else ""
        self.held = values.get("reason", message.message) if state == HELD else ""

    def _take_controller_state(self, message: DiagnosticStatus, _: float) -> None:
        stands = values_of(message).get("maneuver") in STANDING or OUT_OF_VIEW in message.message
        self.standing = message.message if stands else ""

    def _take_goal_status(self, message: GoalStatus, sent: float) -> None:
        if sent >= self._asked:
            self.goal = GoalReport(message.status, sent)

    def _take_pose(self, _: bytes, sent: float) -> None:
        if self.newest is not None and self.newest.sent == sent:
            self.lateness = max(0.0, self._times.now() - sent)

    def _take_scan(self, message: LaserScan, _: float) -> None:
        if self.scan_came:
            return
        try:
            scan = used_scan(scan_from_message(message, self._base, self._scan_input), self._scan_input)
            self.scan_came, self.blind = True, blind_angle(scan)
        except ScanError as error:
            self.scan_refused = str(error)

    def _take_maneuver(self, message: String, _: float) -> None:
        self.maneuver = message.data

    def _take_command(self, message: Twist | TwistStamped, sent: float) -> None:
        with suppress(MessageError):
            (vx, vy), wz = velocity_from_twist(twist_of(message))
            self.stands_since = math.inf if vx or vy or wz else sent
