"""Frames of a recorded run: those that the live page would have shown of it."""

import json
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from collplan_core.clock_steps import RunTimes
from collplan_core.scan import ScanError
from collplan_ros.messages.reading import MessageError
from collplan_ros.run.reader import raw_messages
from collplan_ros.run.recorded_run import NANO, RecordedRun
from collplan_ros.view import scene
from collplan_ros.view.drawn_graph import DrawnGraph, Stamps
from collplan_ros.view.frames import Changes

Frame = dict[str, Any]
"""A frame, by part: see `view.scene`."""

POSES, COMMANDS, STATUS = "mocap/odom", "cmd_vel", "goal_status"
NOT_TAKEN = {"impact/contact", "goal_pose", "shared_constants"}
"""Topics whose content is taken from the run's results, marks and parameters: true impacts, where they are known."""
DECIMATED = ("scan", "planner/seen", "planner/compared")
"""Topics of which not every message of a long run is shown."""
PERIOD = 0.05
"""Time between two frames [s], but where something of OWN_FRAME comes."""
EARLY = 1e-3
"""Tolerance of times [s]: sums of decimal times must not decide."""
OWN_FRAME = ("plan", "impacts")
"""Parts that the next pose has a frame for: steps go from one to the next."""
OF_A_CLOCK = {"machine", "periods"}
"""Parts of wall-clock time: of a run that no clock paced they tell nothing."""
LATEST = 0.5
"""Messages so long after the last pose still belong to the last frame [s]: the goal's end is reported after it."""
HEAVY = frozenset(
    {"scan", "free", "frontiers", "predicted", "remembered", "inferred", "candidates", "rollouts", "plan"}
)
"""Parts that most of a page consists of."""
PLAN_LATER = 4
"""Ratio of plans to other heavy parts kept, where not all are."""
SHOWN_WHOLE = 60.0
"""A shorter run is shown with all its scans, maps and sets of candidates, as far as its page has room [s]."""


def decimation(run: RecordedRun) -> int:
    """Decimation factor of scans, maps and sets of candidates: all those of a long run fill the memory."""
    return 1 + int(run.log.duration // SHOWN_WHOLE)


class RunStamps(Stamps):
    """Shows times of the run, which begin at zero and go on over steps of the clock."""

    def __init__(self, pace: float, zero: float) -> None:
        """`pace` as in `RunTimes`; `zero` is the time [s] that is shown as 0."""
        self._times = RunTimes(pace)
        self._zero = zero
        self._newest = 0.0  # time shown of the newest pose [s]
        super().__init__(lambda: self._newest)

    def of_pose(self, stamp: float, sent: float) -> float:
        """Time shown [s] of the next pose."""
        self._newest = self._times.of_pose(stamp, sent) - self._zero
        return self._newest

    def of(self, stamp: float) -> float:
        """Time shown [s] of the stamp [s] of another message."""
        return self._times.of(stamp) - self._zero


class Event(NamedTuple):
    """Something that was sent [s], whether it is a pose, and what takes it."""

    sent: float
    is_pose: bool
    take: Callable[[], None]


def frames_of(run: RecordedRun) -> list[Frame]:
    """The frames of a run; every pose is in one of them, as `robot` or in `trail`.

    RunError: the recording cannot be read. SceneError: a number in it cannot be drawn.
    """
    changes, stamps = Changes(), RunStamps(run.log.pace, run.log.begin)
    graph = DrawnGraph(run.settings, changes, run.namespace, stamps)
    for part, value in _beginning(run).items():
        changes.put(part, value)
    graph.goal = run.log.goal if np.isfinite(run.log.goal).all() else None
    graph.put_goal()
    frames, due = list[Frame](), -np.inf
    events = [*_goals(run, graph), *_impacts(run, graph), *_messages(run, graph)]
    for event in sorted(events, key=lambda each: each.sent):
        try:
            event.take()
        except (MessageError, ScanError):
            continue  # a message that is invalid is not shown
        # the last frame is that of the last pose, and of what came after it
        is_due = stamps.now() >= due - EARLY or changes.hold(OWN_FRAME)
        if event.is_pose and is_due and event.sent < run.log.poses[-1].sent:
            frames.append(_frame(graph, changes, run.log.pace))
            due = stamps.now() + PERIOD
    return [*frames, _frame(graph, changes, run.log.pace)]


def _frame(graph: DrawnGraph, changes: Changes, pace: float) -> Frame:
    parts = changes.take(graph.put_frame()).items()
    return {part: json.loads(text) for part, text in parts if pace or part not in OF_A_CLOCK}


def _beginning(run: RecordedRun) -> Frame:
    """Parts that hold from the first frame on."""
    kind = scene.SIMULATED if run.log.simulated else scene.REAL
    return {
        "about": scene.about(kind, "/", run.world.name, run.settings),
        "world": scene.world(run.world),
        "machine": {"pace": run.end.pace, "verdict": run.end.machine},
        "impacts": [],
    }


def _goals(run: RecordedRun, graph: DrawnGraph) -> Iterator[Event]:
    def give(x: float, y: float) -> None:
        graph.goal = np.array([x, y])
        graph.put_goal()

    for goal in run.log.goals:
        yield Event(goal.sent, False, partial(give, goal.x, goal.y))


def _impacts(run: RecordedRun, graph: DrawnGraph) -> Iterator[Event]:
    """Each impact, before the first pose after it."""

    def happen(shown: scene.Part) -> None:
        graph.impacts.add(shown)
        graph.put_impacts()

    poses = run.log.poses
    for k, impact in enumerate(run.record.impacts):
        following = poses[bisect_left(poses, impact.time, key=lambda pose: pose.stamp) :][:1]
        if following or impact.time <= poses[-1].stamp + LATEST:
            shown = scene.impact(replace(impact, time=impact.time - run.log.begin), run.record.verdicts.kind(k))
            yield Event(following[0].sent if following else poses[-1].sent, False, partial(happen, shown))


def _messages(run: RecordedRun, graph: DrawnGraph) -> Iterator[Event]:
    """The messages that the page shows, up to LATEST after the last pose; of a long run not all scans and clouds."""
    log, counts = run.log, Counter[str]()
    first, last = log.poses[0], log.poses[-1]
    begun = log.goals[0].sent if log.goals else np.inf
    for each in raw_messages(run.recording, [*graph.takers.keys() - NOT_TAKEN]):
        sent = (each.sent - run.clock_ahead) / NANO
        counts[each.topic] += 1
        if (
            (each.topic in (POSES, COMMANDS) and not first.sent <= sent <= last.sent)
            or (each.topic == STATUS and sent < begun)  # of an earlier goal
            or (each.topic in DECIMATED and (counts[each.topic] - 1) % decimation(run))
            or log.stamp_at(sent) > last.stamp + LATEST
        ):
            continue
        if (message := each.content) is not None:
            yield Event(sent, each.topic == POSES, partial(graph.takers[each.topic], message, sent))


def thinned(frames: Sequence[Frame], factor: int) -> list[Frame]:
    """The frames with every `factor`-th of each heavy part; poses and what happened are kept, and the first of each."""
    seen: dict[str, int] = {}
    result = []
    for frame in frames:
        kept = {}
        for part, value in frame.items():
            if part in HEAVY:
                seen[part] = seen.get(part, -1) + 1
                if seen[part] % (max(factor // PLAN_LATER, 1) if part == "plan" else factor):
                    continue
            kept[part] = value
        result.append(kept)
    return result
