"""Reading record.jsonl back: the log of a run, also of one that was killed.

| kind | entries |
|---|---|
| run | `{"simulated": ..., "goal": [x, y], "pace": stamps to `sent`, "wall_clock": [[since, ahead], ...]}`, as below |
| wall_clock | since when, by the clock of `sent` [s], and by how much the wall clock is ahead of that [s]; at changes |
| asked | when the goal was given |
| pose, truth | stamp, x, y, yaw, vx, vy, sent |
| clock | everything that was added to the stamps of poses so far |
| command, maneuver, reference | sent, and what was sent |
| plan | sent, stamp, times, positions |
| contacts | sent, stamp of the plan, times, points, velocities after |
| scan | sent, stamp, angle_min, angle_increment, range_min, range_max, time_increment, ranges |
| true_impact | sent, stamp, dvx, dvy |
| impact | sent, stamp, x, y, normal_x, normal_y |
| costs | sent, figures by name |
| goal | sent, status |
| health | sent, node, level, message; at every change |
| robot | sent, state, why it does not move; at every change |
| waited | sent, longest time that the simulation waited for a node [s], which; at every change |
| end | stamp and sent of the pose that ends the run |
"""

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from collplan_core.goal import SUCCEEDED
from collplan_core.plan import Contacts
from collplan_core.scan import Scan
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
from collplan_ros.runs.run_times import continued

RECORD = "record.jsonl"
PICTURED = ("plan", "scan")
"""Kinds that nothing but the pictures need, and most of a record is."""


class Told(NamedTuple):
    """What a node told of itself: when it was sent [s], kind of the line, and its other entries."""

    sent: float
    kind: str
    entries: tuple[Any, ...]


@dataclass
class Record:
    """What was recorded of a run.

    Attributes:
        log: the log of the run, up to its end.
        simulated: whether the robot was simulated.
        goal: (2,) [m], the last one given; NaN where the run was killed before it had one.
        wall_clock: since when by the clock of `sent` [s], and by how much the wall clock was ahead of it [s]; in order.
        told: lines of the kinds costs, goal, health and robot, and as `target` each goal given, in order of receipt.
    """

    log: RunLog = field(default_factory=RunLog)
    simulated: bool = False
    goal: np.ndarray = field(default_factory=lambda: np.full(2, math.nan))
    wall_clock: list[tuple[float, float]] = field(default_factory=lambda: [(-math.inf, 0.0)])
    told: list[Told] = field(default_factory=list)


def read_record(path: Path, pictured: bool = True) -> Record:
    """The run in a file; without plans and scans where it is not `pictured`. Without such a file the run is empty.

    Raises:
        OSError: the file cannot be read.
    """
    reading = _Reading()
    if path.exists():
        for kind, *entries in _lines(path, () if pictured else PICTURED):
            reading.take[kind](*entries)
    return reading.record()


def _lines(path: Path, without: tuple[str, ...]) -> Iterator[list[Any]]:
    beginnings = tuple(f'["{kind}",' for kind in without)
    with path.open() as file:
        for line in file:
            if beginnings and line.startswith(beginnings):
                continue
            try:
                yield json.loads(line)
            except ValueError:  # cut off where the process was killed or the disk was full
                return


class _Reading:
    """Takes the lines of a record by their kind."""

    def __init__(self) -> None:
        self._record = Record()
        self._corrections = [0.0]
        self._end: PoseRow | None = None
        log = self._log = self._record.log
        self.take: dict[str, Callable[..., None]] = {
            "run": self._take_header,
            "asked": self._take_asked,
            "pose": lambda *entries: log.poses.append(PoseRow(*entries)),
            "clock": self._take_clock,
            "wall_clock": lambda since, ahead: self._record.wall_clock.append((since, ahead)),
            "command": lambda *entries: log.sent_commands.append(SentCommand(*entries)),
            "maneuver": lambda *entries: log.sent_maneuvers.append(SentManeuver(*entries)),
            "reference": lambda *entries: log.sent_references.append(SentReference(*entries)),
            "truth": lambda stamp, *entries: log.truth.append(PoseRow(self._time(stamp), *entries[:-1])),
            "plan": self._take_plan,
            "contacts": self._take_contacts,
            "scan": self._take_scan,
            "true_impact": lambda _, stamp, *change: log.true_impacts.append(ImpactRecord(self._time(stamp), *change)),
            "impact": lambda _, stamp, *place: log.detected_impacts.append(
                DetectedImpactRecord(self._time(stamp), *place)
            ),
            "costs": self._take_costs,
            "goal": self._take_goal,
            "health": lambda sent, *entries: self._tell(sent, "health", *entries),
            "robot": lambda sent, *entries: self._tell(sent, "robot", *entries),
            "waited": self._take_waited,
            "end": self._take_end,
        }

    def record(self) -> Record:
        """Everything taken, up to the end of the run."""
        if self._end is not None:
            self._log.end_with(self._end)
        return self._record

    def _time(self, stamp: float) -> float:
        """Time of the run [s] at a stamp of another message than a pose."""
        return continued(stamp, self._log.poses[-1].stamp if self._log.poses else stamp, self._corrections)

    def _tell(self, sent: float, kind: str, *entries: Any) -> None:
        self._record.told.append(Told(sent, kind, entries))

    def _take_header(self, header: dict[str, Any]) -> None:
        self._record.simulated, self._record.goal = header["simulated"], np.array(header["goal"], dtype=float)
        # records of earlier versions tell no pace, and one setting for the whole run
        self._log.pace = header.get("pace", 1.0)
        told = header.get("wall_clock", [(-math.inf, header.get("wall_clock_ahead", 0.0))])
        self._record.wall_clock = [(since, ahead) for since, ahead in told]
        self._tell(self._log.poses[-1].sent if self._log.poses else -math.inf, "target", *header["goal"])

    def _take_asked(self, _: float) -> None:
        self._log.reached_sent = self._end = None

    def _take_clock(self, corrections: list[float]) -> None:
        self._corrections = corrections

    def _take_costs(self, sent: float, figures: dict[str, float]) -> None:
        self._log.costs.append(figures)
        self._tell(sent, "costs", figures)

    def _take_goal(self, sent: float, status: str) -> None:
        self._log.reached_sent = sent if status == SUCCEEDED else None
        self._tell(sent, "goal", status)

    def _take_waited(self, _: float, longest: float, node: str) -> None:
        self._log.longest_wait = longest, node

    def _take_end(self, stamp: float, sent: float) -> None:
        self._end = PoseRow(stamp, 0.0, 0.0, 0.0, 0.0, 0.0, sent)

    def _take_plan(self, sent: float, stamp: float, times: list[float], positions: list[list[float]]) -> None:
        at = self._time(stamp)
        self._log.plans.append(PlanRow(at, at - stamp + np.array(times), np.array(positions).reshape(-1, 2), sent))

    def _take_contacts(self, _: float, stamp: float, times: list[float], *vectors: list[list[float]]) -> None:
        at = self._time(stamp)
        points, after = (np.array(each).reshape(-1, 2) for each in vectors)
        self._log.contacts[at] = Contacts(at - stamp + np.array(times), points, after)

    def _take_scan(self, _: float, stamp: float, *entries: Any) -> None:
        first, step, nearest, farthest, between, ranges = entries
        self._log.scans.append(Scan(self._time(stamp), first, step, nearest, farthest, np.array(ranges), between))
