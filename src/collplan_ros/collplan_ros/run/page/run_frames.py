"""Frames of a run from its poses and the events between them, as the live page would have received them."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from collplan_core.state import State
from collplan_ros.run.run_log import PoseRow
from collplan_ros.view import scene
from collplan_ros.view.frames import LOSSY

Frame = dict[str, Any]
"""A frame, by part: see `view.scene`."""

PERIOD = 0.05
"""Time between two frames [s], but where something of OWN_FRAME comes."""
EARLY = 1e-3
"""Tolerance of times [s]: sums of decimal times must not decide."""
OWN_FRAME = frozenset({"plan", "impacts"})
"""Parts that the next pose has a frame for: steps go from one to the next."""
LATEST = 0.5
"""Events so long after the last pose still belong to the last frame [s]: the goal's end is reported after it."""
HEAVY = frozenset(
    {"scan", "free", "frontiers", "predicted", "remembered", "inferred", "candidates", "rollouts", "plan"}
)
"""Parts that most of a page consists of."""
PLAN_LATER = 4
"""Ratio of plans to other heavy parts kept, where not all are."""


class Event(NamedTuple):
    """A part that was new at a time [s, poses' clock]."""

    time: float
    part: str
    value: scene.Part


def frames_of(poses: Sequence[PoseRow], events: Iterable[Event], beginning: Frame, zero: float) -> list[Frame]:
    """The frames of a run; every pose is in one of them, as `robot` or in `trail`.

    Args:
        poses: at least one, in order.
        events: new parts, in any order.
        beginning: parts of the first frame.
        zero: t = 0 of the frames [s, poses' clock].
    """
    waiting = sorted((event for event in events if event.time <= poses[-1].stamp + LATEST), key=lambda each: each.time)
    frames: list[Frame] = []
    newest: Frame = {}
    parts, passed, taken, due = dict(beginning), list[State](), 0, poses[0].stamp
    for k, pose in enumerate(poses):
        is_last = k == len(poses) - 1
        while taken < len(waiting) and (is_last or waiting[taken].time <= pose.stamp):
            _take(parts, waiting[taken])
            taken += 1
        if not is_last and pose.stamp < due - EARLY and not parts.keys() & OWN_FRAME:
            passed.append(pose.state)
            continue
        trail = {"trail": scene.trail(passed, pose.stamp)} if passed else {}
        changed = {part: value for part, value in parts.items() if part in LOSSY or _differs(newest, part, value)}
        newest |= changed
        frames.append({"t": scene.time_of(pose.stamp - zero), "robot": scene.robot(pose.state), **trail, **changed})
        parts, passed, due = {}, [], pose.stamp + PERIOD
    return frames


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


def _take(parts: Frame, event: Event) -> None:
    if event.part == "periods":
        parts.setdefault("periods", []).extend(event.value)
    else:
        parts[event.part] = event.value


def _differs(newest: Frame, part: str, value: scene.Part) -> bool:
    return part not in newest or newest[part] != value
