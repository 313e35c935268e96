"""Frames on their way to pages: changed parts, and the newest of each part."""

import json
import math
from collections import deque
from collections.abc import Collection, Mapping
from typing import Any

HISTORY = ("robot", "trail", "costs", "periods")
"""Parts of which earlier ones are kept, for a page that comes late."""
KEPT = 1200
"""Frames of history that are kept: a minute at 20 Hz."""
STEP_BACK = 0.5
"""A frame that is so much before the one before it begins another time, as after a restart of the robot [s]."""
LOSSY = ("trail", "periods")
"""Parts that belong to one frame alone: the newest does not contain the earlier ones."""
REPEATED = (*LOSSY, "robot")
"""Parts that are sent whenever they are put, also as they were: a robot at rest is still measured."""

Texts = Mapping[str, str]
"""Parts of a frame by name, each as JSON."""


def as_json(value: Any) -> str:
    """A value as strict JSON in ASCII, without spaces; ValueError: a number in it is not finite."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False)


def joined(parts: Texts) -> str:
    """One JSON object of parts that are JSON already."""
    return "{" + ",".join(f'"{name}":{text}' for name, text in parts.items()) + "}"


class Changes:
    """Collects the parts of the next frame; unchanged parts are left out."""

    def __init__(self) -> None:
        self._newest: dict[str, str] = {}
        self._changed: dict[str, str] = {}

    def put(self, name: str, value: Any) -> None:
        """Sets a part, if it differs from the newest of its name or is one of REPEATED; ValueError: not finite."""
        text = as_json(value)
        if name in REPEATED or self._newest.get(name) != text:
            self._newest[name] = self._changed[name] = text

    def hold(self, names: Collection[str]) -> bool:
        """Returns whether one of these parts has changed since the previous frame."""
        return any(name in self._changed for name in names)

    def forget(self) -> None:
        """Forgets all parts: every part is a change from now on."""
        self._newest.clear()
        self._changed.clear()

    def take(self, time: float) -> Texts:
        """Returns the frame at a time [s]: all parts changed since the previous one."""
        changed, self._changed = self._changed, {}
        return {"t": as_json(time), **changed}


class Newest:
    """The newest of each part of the frames so far, and their history."""

    def __init__(self) -> None:
        self._parts: dict[str, str] = {}
        self._history: deque[str] = deque(maxlen=KEPT)
        self._time = -math.inf

    def add(self, frame: Texts) -> None:
        """Takes the next frame; one of an earlier time begins another history."""
        time = float(frame["t"])
        if time < self._time - STEP_BACK:
            self._history.clear()
        self._time = time
        self._parts.update((name, text) for name, text in frame.items() if name not in LOSSY)
        kept = {name: frame[name] for name in HISTORY if name in frame}
        if kept:
            self._history.append(joined({"t": frame["t"], **kept}))

    def whole(self) -> Texts:
        """Returns the frame for a new page: all parts, with the history; empty before the first frame."""
        return {**self._parts, "history": f"[{','.join(self._history)}]"} if self._parts else {}

    def forget(self) -> None:
        """Forgets everything."""
        self._parts.clear()
        self._history.clear()
