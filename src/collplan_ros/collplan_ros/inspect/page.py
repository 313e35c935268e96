"""inspect.html: what came out of the stages, played as run.html plays a run, and the findings in words beside it."""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from collplan_core.impact import Impact
from collplan_core.local_map import build_local_map
from collplan_core.movers.record import Movers
from collplan_core.parameters import Settings
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.time_to_goal_planner.boundary_memory.update import remember
from collplan_core.time_to_goal_planner.boundary_memory.working import RememberedBoundaries
from collplan_ros.inspect.stages import Happened
from collplan_ros.inspect.words import WRONG, Line
from collplan_ros.run.page.run_frames import EARLY, PERIOD, Frame
from collplan_ros.run.page.run_page import Recording, write_recordings
from collplan_ros.view import scene
from collplan_ros.view.scene import ShownImpacts

PAGE = "inspect.html"
MAP_PERIOD, MAPPED, AROUND = 1.0, 4.0, 1.0
"""Time between two maps [s], half the side of each, as a planner's own ends before most walls, and shown around [m]."""
QUIET, READ = 0.5, 1.0
"""Time without a pose after which a frame goes without one, and for which the reason of a refusal is shown [s]."""


def write_inspect_page(
    path: Path, name: str, happened: Sequence[Happened], settings: Settings, lines: Sequence[Line]
) -> None:
    """Writes the page of a recording, from what came out of the stages with these settings, and the findings in words.

    RecordError: the file cannot be written.
    """
    wrong = "; ".join(f"{verdict}: {text}" for verdict, text in lines if verdict == WRONG)
    notes = [f"{verdict}: {text}" for verdict, text in lines if verdict != WRONG]
    told = {"title": name, "end": "as found", "reason": wrong, "notes": notes}
    frames = Drawing(settings).frames_of(name, happened)
    write_recordings(path, f"inspect {name}", [Recording(told, frames, frames[-1]["t"])])


class Drawing:
    """Makes the frames of a recording, whose times are those of receipt: a robot would have known nothing earlier."""

    def __init__(self, settings: Settings) -> None:
        """Nothing has happened yet."""
        self._settings = settings
        self._frame: Frame = {}
        self._states: list[State] = []
        self._impacts = ShownImpacts()
        self._memory: RememberedBoundaries | None = None
        self._at, self._mapped, self._read = 0.0, -math.inf, -math.inf
        self._stands = self._reason = ""
        self._place = np.zeros(2)

    def frames_of(self, name: str, happened: Sequence[Happened]) -> list[Frame]:
        """The frames; what holds a number that cannot be drawn is left out."""
        frames, due, places = list[Frame](), -math.inf, [self._place]
        for received, what, args in happened:
            self._at = received - happened[0][0]
            with suppress(scene.SceneError):
                getattr(self, what)(*args)
            if self._at >= due - EARLY and (self._states or self._at >= due + QUIET):
                frames.append(self._taken())
                places.append(self._place)
                due = self._at + PERIOD
        frames.append(self._taken())
        seen = np.vstack(
            [*places[1:], *([] if self._memory is None else self._memory.pieces.reshape(-1, 2)), places[-1]]
        )
        bounds = scene.milli([*seen.min(axis=0) - AROUND, *seen.max(axis=0) + AROUND])
        radius, speed = scene.milli([self._settings.robot.radius, self._settings.robot.max_speed])
        about = {"robot": scene.UNKNOWN, "namespace": "/", "world": name, "radius": radius, "max_speed": speed}
        world = {"bounds": bounds, "walled": False, "polygons": [], "circles": []}
        frames[0] = {"about": about, "world": world, "impacts": [], **frames[0]}
        return frames

    def _taken(self) -> Frame:
        frame, self._frame = self._frame, {}
        states, self._states = self._states, []
        if states:
            frame |= {"robot": scene.robot(states[-1]), "trail": scene.trail(states[:-1], self._at)}
        reason = self._stands or (self._reason if self._at < self._read else "")
        doing = {"maneuver": "would stand" if self._stands else "driven", "reason": reason, "warn": bool(reason)}
        return {"t": scene.time_of(self._at), **frame, "doing": doing}

    def pose(self, state: State) -> None:
        """The newest state."""
        scene.robot(state)  # it may be too far off
        self._states.append(replace(state, stamp=self._at))
        self._place = state.position

    def impact(self, impact: Impact) -> None:
        """An impact that the poses show."""
        self._impacts.happened(replace(impact, time=self._at))
        self._frame |= {"impacts": self._impacts.part, "counts": self._impacts.counts}

    def scan(self, scan: Scan, state: State, movers: Movers) -> None:
        """A scan that is used, the state at its stamp, and what moves then."""
        found = scene.movers(self._at, movers.rows[:, :5])
        self._frame |= {"scan": scene.scan(scan, state), "refuses": False, "found": found}
        if self._at >= self._mapped + MAP_PERIOD:
            self._mapped, settings = self._at, self._settings
            seen = build_local_map(scan, state, settings.robot, replace(settings.local_map, half_side=MAPPED))
            self._memory = remember(self._memory, seen, settings.robot, settings.remembered)
            self._frame |= {"free": scene.milli(seen.border_points), "remembered": scene.milli(self._memory.pieces)}

    def refused_scan(self, reason: str, scan: Scan | None, state: State | None) -> None:
        """A scan that is refused, and the state at its stamp, where those are known."""
        self._refuse(f"scan refused: {reason}", None if state is None else state.position, 1)
        if scan is not None and state is not None:
            self._frame |= {"scan": scene.scan(scan, state), "refuses": True}

    def refused_pose(self, reason: str, at: np.ndarray | None) -> None:
        """A pose that is refused, and its place (2,) [m], where it has one."""
        self._refuse(f"pose refused: {reason}", at, 0)

    def _refuse(self, reason: str, at: np.ndarray | None, kind: int) -> None:
        self._reason, self._read = reason, self._at + READ
        self._frame.setdefault("refused", []).append([*scene.milli(self._place if at is None else at), kind])

    def stands(self, why: str) -> None:
        """Why the robot would have to stand from now on; "" where it would not."""
        self._stands = why
