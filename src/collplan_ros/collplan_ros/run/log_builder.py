"""Fills the log of a run from its messages: as they come, or as run.mcap holds them."""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

from collplan_core.clock_steps import RunTimes
from collplan_core.goal import NO_GOAL, SUCCEEDED
from collplan_core.parameters import Settings
from collplan_core.state import State
from collplan_ros.messages.cloud_reading import impact_from_cloud, plan_from_message
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.messages.reading import GOAL_STATUS, MessageError, check_finite, twist_of, velocity_from_twist
from collplan_ros.messages.status_values import drive_figures
from collplan_ros.run.run_log import PoseRow, RunLog, SentCommand, SentGoal, SentManeuver, SentReference, SentStatus

FIGURES = ("planning_time_ms", "candidates", "candidates_before_pruning", "hardest_contact")
"""Figures of planner/costs that are logged."""


class End(NamedTuple):
    """End of a run: stamp of its last pose, and when that was sent [s]."""

    stamp: float
    sent: float


NO_END_YET, NOT_STARTED = End(math.inf, math.inf), End(-math.inf, -math.inf)
"""Logging, and not logging."""


class LogBuilder:
    """Takes the messages of a run, from `begin` to `end`, in whatever order the topics come.

    Attributes:
        topics: the topics that it takes.
        newest: newest pose, also while nothing is logged; None before the first.
        time_zero: time of the first command to move, by the newest pose then [s]; None before it.
    """

    def __init__(self, settings: Settings) -> None:
        self.newest: PoseRow | None = None
        self.time_zero: float | None = None
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

    def drop(self) -> None:
        """Drops the log so far, so that the memory of a graph that drives to goal after goal does not grow."""
        drive, words = self._log.drive, self._log.drive_in_words
        self._log = RunLog(pace=self._log.pace, drive=drive, drive_in_words=words)

    def begin(self, simulated: bool) -> None:
        """Logs messages from now on."""
        self._log.simulated = simulated
        self._end, self._ended = NO_END_YET, None

    def ask(self, goal: SentGoal) -> None:
        """Notes that a goal is given; reports of earlier goals no longer count."""
        self._log.goals.append(goal)
        self._log.reached_sent = self._ended = self._arrived = None

    def take(self, topic: str, message: Any, sent: float) -> None:
        """Takes a message sent at `sent` [s], or its bytes on a topic of BYTES_TOPICS; an invalid one is left out."""
        with suppress(MessageError):
            self._takers[topic](message, sent)

    @property
    def is_open(self) -> bool:
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
        self._log.statuses.append(SentStatus(sent, status))
        self._log.reached_sent = sent if status == SUCCEEDED else None

    def _take_reference(self, message: Any, sent: float) -> None:
        point = float(message.point.x), float(message.point.y)
        check_finite("controller/reference", *point)
        if sent <= self._end.sent:
            self._log.sent_references.append(SentReference(sent, *point))

    def _take_maneuver(self, message: Any, sent: float) -> None:
        if sent <= self._end.sent:
            # a text that is no Unicode could not be written to a file
            self._log.sent_maneuvers.append(SentManeuver(sent, message.data.encode(errors="replace").decode()))

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
