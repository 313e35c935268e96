"""inspect.html: what came out of the stages, played as run.html plays a run, and the findings in words beside it."""

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.local_map import build_local_map
from collplan_core.movers.record import Movers
from collplan_core.parameters import Settings
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.time_to_goal_planner.boundary_memory.record import RememberedBoundaries
from collplan_core.time_to_goal_planner.boundary_memory.update import remember
from collplan_ros.inspect.stages import IMPACT, POSE, REFUSED_POSE, REFUSED_SCAN, SCAN, STANDS, Happened
from collplan_ros.inspect.words import WRONG, Line
from collplan_ros.run.page.one_file import one_file
from collplan_ros.run.page.played_run import SHOWN_WHOLE
from collplan_ros.run.page.run_frames import EARLY, PERIOD, Frame
from collplan_ros.run.page.run_page import fitted, largest_file
from collplan_ros.run.whole_file import replacing
from collplan_ros.view import scene
from collplan_ros.view.impacts import ShownImpacts

PAGE = "inspect.html"
MAP_PERIOD, MAPPED = 0.5, 4.0
"""Time between two maps [s], and half the side of what each shows [m]: a planner's own ends before most walls."""
AROUND = 1.0
"""Shown around the way and the walls [m]."""
QUIET = 0.5
"""Time without a pose after which a frame goes without one [s]."""
READ = 1.0
"""Time for which the reason of a refusal is shown [s]."""


def write_inspect_page(
    path: Path, name: str, happened: Sequence[Happened], settings: Settings, lines: Sequence[Line]
) -> None:
    """Writes the page of a recording of this name.

    Args:
        path: the file.
        name: that of the recording.
        happened: what came out of the stages.
        settings: the parameters with which it did.
        lines: the findings in words.

    Raises:
        RecordError: the file cannot be written.
    """
    duration = happened[-1].received - happened[0].received if happened else 0.0
    decimation = 1 + int(duration // SHOWN_WHOLE)
    wrong = "; ".join(text for verdict, text in lines if verdict == WRONG)
    notes = [f"{verdict}: {text}" for verdict, text in lines if verdict != WRONG]
    told = {"title": name, "end": "as found", "reason": wrong and f"{WRONG}: {wrong}", "notes": notes}
    frames, title = PlayedRecording(settings, decimation).frames_of(name, happened), f"inspect {name}"
    text = one_file(title, [fitted(told, frames, largest_file(duration) - len(one_file(title, [])), decimation)])
    with replacing(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8", newline="\n")


class PlayedRecording:
    """Makes the frames of a recording, whose times are those of receipt: a robot would have known nothing earlier."""

    def __init__(self, settings: Settings, decimation: int) -> None:
        """One in `decimation` scans is shown."""
        self._settings, self._decimation = settings, decimation
        self._frame: Frame = {}
        self._states: list[State] = []
        self._impacts = ShownImpacts()
        self._memory: RememberedBoundaries | None = None
        self._scans, self._mapped = 0, -math.inf
        self._stands, self._reason, self._read = "", "", -math.inf
        self._place, self._seen = np.zeros(2), np.zeros((0, 2))

    def frames_of(self, name: str, happened: Sequence[Happened]) -> list[Frame]:
        """The frames; a number that cannot be drawn is left out with what it belongs to."""
        takers: dict[int, Callable[[Any, float], None]] = {
            POSE: self._take_pose,
            IMPACT: self._take_impact,
            SCAN: self._take_scan,
            REFUSED_POSE: self._refuse_pose,
            REFUSED_SCAN: self._refuse_scan,
            STANDS: self._stand,
        }
        frames: list[Frame] = []
        begin, due = happened[0].received if happened else 0.0, -math.inf
        for each in happened:
            at = each.received - begin
            with suppress(scene.SceneError):
                takers[each.kind](each.what, at)
            if at >= due - EARLY and (each.kind == POSE or at >= due + QUIET):
                frames.append(self._taken(at))
                due = at + PERIOD
        frames.append(self._taken(happened[-1].received - begin if happened else 0.0))
        frames[0] = {**self._beginning(name), **frames[0]}
        return frames

    def _taken(self, at: float) -> Frame:
        frame, self._frame = self._frame, {}
        states, self._states = self._states, []
        if states:
            frame["robot"] = scene.robot(states[-1])
            frame["trail"] = scene.trail(states[:-1], at)
        reason = self._stands or (self._reason if at < self._read else "")
        doing = {"maneuver": "would stand" if self._stands else "driven", "reason": reason, "warn": bool(reason)}
        return {"t": scene.time_of(at), **frame, "doing": doing}

    def _beginning(self, name: str) -> Frame:
        robot, pieces = self._settings.robot, np.zeros((0, 2)) if self._memory is None else self._memory.pieces
        places = np.vstack([self._seen, pieces.reshape(-1, 2)])
        about = {
            "robot": scene.UNKNOWN,
            "namespace": "/",
            "world": name,
            "radius": scene.milli([robot.radius])[0],
            "max_speed": scene.milli([robot.max_speed])[0],
        }
        bounds = [*places.min(axis=0) - AROUND, *places.max(axis=0) + AROUND] if len(places) else [0.0, 0.0, 1.0, 1.0]
        world = {"bounds": scene.milli(bounds), "walled": False, "polygons": [], "circles": []}
        return {"about": about, "world": world, "impacts": []}

    def _take_pose(self, state: State, at: float) -> None:
        scene.robot(state)  # may not be drawn
        self._states.append(replace(state, stamp=at))
        self._place = state.position
        seen = np.vstack([self._seen, self._place])
        self._seen = np.array([seen.min(axis=0), seen.max(axis=0)])

    def _take_impact(self, impact: Any, at: float) -> None:
        self._impacts.happened(replace(impact, time=at))
        self._frame |= {"impacts": self._impacts.part, "counts": self._impacts.counts}

    def _take_scan(self, what: tuple[Scan, State, Movers], at: float) -> None:
        scan, state, movers = what
        self._scans += 1
        if (self._scans - 1) % self._decimation:
            return
        self._frame |= {
            "scan": scene.scan(scan, state),
            "refuses": False,
            "found": scene.movers(at, movers.rows[:, :5]),
        }
        if at >= self._mapped + MAP_PERIOD * self._decimation:
            self._mapped, settings = at, self._settings
            mapping = replace(settings.local_map, half_side=MAPPED)
            seen = build_local_map(scan, state, settings.robot, mapping)
            self._memory = remember(self._memory, seen, settings.robot, settings.remembered)
            self._frame |= {"free": scene.milli(seen.border_points), "remembered": scene.milli(self._memory.pieces)}

    def _refuse_pose(self, what: tuple[str, np.ndarray | None], at: float) -> None:
        reason, place = what
        self._refuse(f"pose refused: {reason}", at, place, 0)

    def _refuse_scan(self, what: tuple[str, Scan | None, State | None], at: float) -> None:
        reason, scan, state = what
        self._refuse(f"scan refused: {reason}", at, None if state is None else state.position, 1)
        if scan is not None and state is not None:
            self._frame |= {"scan": scene.scan(scan, state), "refuses": True}

    def _refuse(self, reason: str, at: float, place: np.ndarray | None, kind: int) -> None:
        self._reason, self._read = reason, at + READ
        drawn = scene.milli(self._place if place is None else place)
        self._frame.setdefault("refused", []).extend([*drawn, kind])

    def _stand(self, why: str, at: float) -> None:
        self._stands = why
