"""The record of a run and what fills it: times are stamps on the poses' clock [s], vectors are in the world frame.

`sent` is the time at which a node passed a message to its middleware [s, steady clock]. It orders messages without a
stamp: a subscriber that falls behind receives the backlogs of its topics in no common order.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from collplan_core.clock_steps import RunTimes
from collplan_core.command import STOPPED, WITHOUT_REFERENCE
from collplan_core.goal import NO_GOAL, SUCCEEDED
from collplan_core.impact import SIMULATED, Impact
from collplan_core.parameters import Settings
from collplan_core.plan import Contacts
from collplan_core.state import State
from collplan_ros.messages.cloud_reading import impact_from_cloud, plan_from_message
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.messages.reading import GOAL_STATUS, MessageError, check_finite, twist_of, velocity_from_twist
from collplan_ros.messages.status_values import drive_figures


class PoseRow(NamedTuple):
    """Pose [m, rad] and velocity [m/s, world frame] of the robot; `sent` is NaN where it is not needed."""

    stamp: float
    x: float
    y: float
    yaw: float
    vx: float
    vy: float
    sent: float = math.nan

    @property
    def state(self) -> State:
        """The robot's state."""
        return State(self.stamp, np.array([self.x, self.y]), np.array([self.vx, self.vy]), self.yaw)


class SentCommand(NamedTuple):
    """A command in the robot's frame [m/s, rad/s], with the time it was sent."""

    sent: float
    vx: float
    vy: float
    wz: float


class SentName(NamedTuple):
    """A maneuver or a status of the goal by its name, with the time it was sent."""

    sent: float
    name: str


class SentPoint(NamedTuple):
    """A goal or a point that is tracked [m], with the time it was sent."""

    sent: float
    x: float
    y: float


@dataclass
class RunLog:
    """Everything recorded of a run, each list in order of receipt."""

    simulated: bool = False
    poses: list[PoseRow] = field(default_factory=list)
    truth: list[PoseRow] = field(default_factory=list)  # of a simulated robot only
    sent_commands: list[SentCommand] = field(default_factory=list)
    sent_maneuvers: list[SentName] = field(default_factory=list)  # each that the controller began
    sent_references: list[SentPoint] = field(default_factory=list)  # that the controller tracked
    plans: dict[float, Contacts] = field(default_factory=dict)  # contacts foreseen by each, by its stamp [s]
    impacts: list[Impact] = field(default_factory=list)  # also those that are measured beside the simulated ones
    costs: list[dict[str, float]] = field(default_factory=list)  # FIGURES of each planning cycle
    goals: list[SentPoint] = field(default_factory=list)  # that bringup gave
    statuses: list[SentName] = field(default_factory=list)  # the planner's reports on the goals, as `goal` names them
    reached_sent: float | None = None  # when the planner reported that the goal is reached; None before
    drive: dict[str, float] = field(default_factory=dict)  # newest figures of it and what was learnt; may be empty
    drive_in_words: str = ""
    pace: float = 1.0  # seconds of stamps per second of the clock of `sent`; 0 where that varies

    @property
    def goal(self) -> np.ndarray:
        """(2,) the goal given last [m]; NaN before the first."""
        return np.array(self.goals[-1][1:]) if self.goals else np.full(2, math.nan)

    @property
    def duration(self) -> float:
        """Time from the first to the last pose [s]."""
        return self.poses[-1].stamp - self.poses[0].stamp

    @property
    def track(self) -> list[PoseRow]:
        """The true poses of a simulated robot, else the measured ones."""
        return self.truth or self.poses

    @property
    def time_zero(self) -> float | None:
        """Time of the first non-zero command [s]; None where there was none, or no pose."""
        moving = next((c for c in self.sent_commands if c.vx or c.vy or c.wz), None)
        return None if moving is None or not self.poses else self.stamp_at(moving.sent)

    @property
    def begin(self) -> float:
        """Time of t = 0 in the files of a run [s]: `time_zero`, or the first pose if the robot was never commanded."""
        first = self.poses[0].stamp if self.poses else 0.0
        return first if self.time_zero is None else self.time_zero

    @property
    def arrival(self) -> float:
        """Time at which the goal was reached [s]: of the last pose, or of the planner's report if that is earlier."""
        last = self.poses[-1].stamp
        return last if self.reached_sent is None else min(last, self.stamp_at(self.reached_sent))

    def figure(self, name: str) -> np.ndarray:
        """(n,) one of FIGURES in each planning cycle that tells it."""
        return np.array([costs[name] for costs in self.costs if name in costs])

    def stamp_at(self, sent: float) -> float:
        """Time on the poses' clock at a time of sending [s]: stamp of the newest pose sent by then, and the time since.

        The log must hold a pose.
        """
        pose = _newest(self.poses, sent) or self.poses[0]
        return pose.stamp + self.pace * (sent - pose.sent)

    @property
    def own_impacts(self) -> list[Impact]:
        """The impacts of the run: of a simulated robot the simulated ones, else those that were measured."""
        return [each for each in self.impacts if (each.source == SIMULATED) == bool(self.truth)]

    def maneuver_at(self, sent: float) -> str:
        """Name of the last maneuver sent by then; STOPPED before the first."""
        maneuver = _newest(self.sent_maneuvers, sent)
        return maneuver.name if maneuver else STOPPED

    def command_at(self, sent: float) -> SentCommand | None:
        """The last command sent by then; None before the first."""
        return _newest(self.sent_commands, sent)

    def end_with(self, stamp: float, sent: float) -> None:
        """Removes everything after a pose of this stamp [s] that was sent then [s]; figures of planning cycles stay."""
        for rows in (self.poses, self.sent_commands, self.sent_maneuvers, self.sent_references):
            del rows[bisect_right(rows, sent, key=lambda row: row.sent) :]
        del self.truth[bisect_right(self.truth, stamp, key=lambda row: row.stamp) :]
        self.impacts = [impact for impact in self.impacts if impact.time <= stamp]
        for made in [made for made in self.plans if made > stamp]:
            del self.plans[made]

    def reference_at(self, sent: float) -> SentPoint | None:
        """The point tracked at that time; None while the robot is stopped, or before the first."""
        return None if self.maneuver_at(sent) in WITHOUT_REFERENCE else _newest(self.sent_references, sent)


Sent = TypeVar("Sent", PoseRow, SentCommand, SentName, SentPoint)


def _newest(rows: Sequence[Sent], sent: float) -> Sent | None:
    following = bisect_right(rows, sent, key=lambda row: row.sent)
    return rows[following - 1] if following else None


FIGURES = ("planning_time_ms", "candidates", "candidates_before_pruning", "hardest_contact")
"""Figures of planner/costs that are logged."""


class End(NamedTuple):
    """End of a run: stamp of its last pose, and when that was sent [s]."""

    stamp: float
    sent: float


NO_END_YET, NOT_STARTED = End(math.inf, math.inf), End(-math.inf, -math.inf)
"""Logging, and not logging."""


class LogBuilder:
    """Fills the log of a run from its messages, from `begin` to `end`, in whatever order the topics come."""

    def __init__(self, settings: Settings) -> None:
        self.newest: PoseRow | None = None
        """Newest pose, also while nothing is logged; None before the first."""
        self.time_zero: float | None = None
        """Time of the first command to move, by the newest pose then [s]; None before it."""
        self._log = RunLog(pace=settings.simulator.speed_factor)
        self._frames = settings.frames
        self._tolerance = settings.planner.goal_tolerance
        self._run_times = RunTimes(settings.simulator.speed_factor)
        self._end = NOT_STARTED
        self._ended: End | None = None
        self._last: PoseRow | None = None
        self._arrived: PoseRow | None = None
        self._takers: dict[str, Callable[[Any, float], None]] = {
            "mocap/odom": self._take_pose,
            "ground_truth/odom": self._take_truth,
            "ground_truth/impact/contact": self._take_impact,
            "impact/contact": self._take_impact,
            "planner/trajectory": self._take_trajectory,
            "planner/costs": self._take_costs,
            "goal_status": self._take_goal_status,
            "controller/reference": self._take_reference,
            "maneuver": self._take_maneuver,
            "cmd_vel": self._take_command,
            "controller/drive": self._take_drive,
        }
        self.topics = tuple(self._takers)
        """The topics that it takes."""

    def begin(self, simulated: bool) -> None:
        """Logs messages from now on."""
        self._log.simulated = simulated
        self._end, self._ended = NO_END_YET, None

    def asked(self, goal: SentPoint) -> None:
        """Notes that a goal is given; reports of earlier goals no longer count."""
        self._log.goals.append(goal)
        self._log.reached_sent = self._ended = self._arrived = None

    def take(self, topic: str, message: Any, sent: float) -> None:
        """Takes a message sent at `sent` [s], or its bytes on a topic of BYTES_TOPICS; an invalid one is left out."""
        with suppress(MessageError):
            self._takers[topic](message, sent)

    @property
    def recording(self) -> bool:
        """True where it has begun and has no end."""
        return self._end == NO_END_YET

    @property
    def n_impacts(self) -> int:
        """Number of the true impacts of a simulated robot, else of the detected ones."""
        return len(self._log.own_impacts)

    @property
    def last(self) -> End:
        """The pose that arrived at a goal that was reached, or else the newest one logged; NOT_STARTED without one."""
        last = (self._arrived if self._log.reached_sent is not None else None) or self._last
        return NOT_STARTED if last is None else End(last.stamp, last.sent)

    def end(self, end: End) -> None:
        """Ends the run with a pose: later messages of the time up to it are still logged."""
        self._end = self._ended = end

    @property
    def is_complete(self) -> bool:
        """True where the truth of a simulated robot has come up to the end."""
        return not self._log.truth or self._log.truth[-1].stamp >= self._end.stamp

    @property
    def log(self) -> RunLog:
        """Log of the run, up to its end where it has one."""
        if self._ended is not None:
            self._log.end_with(*self._ended)
        return self._log

    def _take_pose(self, raw: bytes, sent: float) -> None:
        state = self._state(raw)
        self.newest = pose = self._row(self._run_times.of_pose(state.stamp, sent), state, sent)
        if sent > self._end.sent:
            return
        self._log.poses.append(pose)
        self._last = pose
        if self._arrived is None and self._log.goals and sent >= self._log.goals[-1].sent:
            _, x, y = self._log.goals[-1]
            self._arrived = pose if math.hypot(pose.x - x, pose.y - y) <= self._tolerance else None

    def _take_truth(self, raw: bytes, sent: float) -> None:
        state = self._state(raw)
        if (time := self._run_times.of(state.stamp)) <= self._end.stamp or not self.is_complete:
            self._log.truth.append(self._row(time, state, sent))

    def _take_impact(self, message: Any, _: float) -> None:
        impact = impact_from_cloud(message, self._frames.map)
        if (time := self._run_times.of(impact.time)) <= self._end.stamp:
            self._log.impacts.append(replace(impact, time=time))

    def _take_trajectory(self, message: Any, sent: float) -> None:
        plan = plan_from_message(message, self._frames.map)
        made = self._run_times.of(plan.stamp)
        if sent <= self._end.sent:
            self._log.plans[made] = replace(plan.contacts, times=made - plan.stamp + plan.contacts.times)

    def _take_costs(self, message: Any, sent: float) -> None:
        for status in message.status:
            figures = {item.key: _number(item) for item in status.values if item.key in FIGURES}
            check_finite("planner/costs", *figures.values())
            if sent <= self._end.sent:
                self._log.costs.append(figures)

    def _take_goal_status(self, message: Any, sent: float) -> None:
        if not self._log.goals or sent < self._log.goals[-1].sent or sent > self._end.sent:
            return
        status = GOAL_STATUS.get(int(message.status), NO_GOAL)
        self._log.statuses.append(SentName(sent, status))
        self._log.reached_sent = sent if status == SUCCEEDED else None

    def _take_reference(self, message: Any, sent: float) -> None:
        point = float(message.point.x), float(message.point.y)
        check_finite("controller/reference", *point)
        if sent <= self._end.sent:
            self._log.sent_references.append(SentPoint(sent, *point))

    def _take_maneuver(self, message: Any, sent: float) -> None:
        if sent <= self._end.sent:
            # a text that is no Unicode could not be written to a file
            self._log.sent_maneuvers.append(SentName(sent, message.data.encode(errors="replace").decode()))

    def _take_command(self, message: Any, sent: float) -> None:
        (vx, vy), wz = velocity_from_twist(twist_of(message))
        if sent > self._end.sent:
            return
        if (vx or vy or wz) and self.time_zero is None and self.newest is not None:
            self.time_zero = self.newest.stamp + self._log.pace * (sent - self.newest.sent)
        self._log.sent_commands.append(SentCommand(sent, float(vx), float(vy), wz))

    def _take_drive(self, message: Any, _: float) -> None:
        self._log.drive = drive_figures(message)
        self._log.drive_in_words = message.message.encode(errors="replace").decode()

    def _state(self, raw: bytes) -> State:
        return state_from_bytes(raw, self._frames.map, self._frames.base)

    @staticmethod
    def _row(time: float, state: State, sent: float) -> PoseRow:
        (x, y), (vx, vy) = state.position.tolist(), state.velocity.tolist()
        return PoseRow(time, x, y, state.yaw, vx, vy, sent)


def _number(item: Any) -> float:
    try:
        return float(item.value)
    except ValueError:
        raise MessageError(f"{item.key}: got {item.value!r}, expected a number") from None
