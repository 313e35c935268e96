"""Writes run.html of a run folder, and the page of several runs."""

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from collplan_core.parameters import Planning
from collplan_core.strategies import TIME_TO_GOAL
from collplan_ros.run.page.one_file import one_file, packed
from collplan_ros.run.page.run_frames import Frame, decimation, frames_of, thinned
from collplan_ros.run.recorded_run import RecordedRun, read_run
from collplan_ros.run.whole_file import RunError, replacing
from collplan_ros.view import scene

PAGE = "run.html"
LARGEST_SHORT, SHORT = 2_000_000, 10.0
"""Largest file of a run of up to so long [bytes], [s]; of a longer one it is larger in proportion."""
LARGEST = 10_000_000
"""Largest file of any run [bytes]."""
COARSEST = 4096
"""Largest decimation factor of the heavy parts of a run."""


def write_run_page(run: Path | RecordedRun) -> Path:
    """Writes the page of a run, or of the run in a folder, into its folder; returns its path.

    RunError: the run cannot be read. RecordError: the file cannot be written.
    """
    shown = read_run(run) if isinstance(run, Path) else run
    path = shown.folder / PAGE
    write_page(path, [shown])
    return path


def write_page(path: Path, runs: Sequence[RecordedRun]) -> None:
    """Writes the page of runs, which it plays beside each other on one clock.

    RunError: a run has no poses, or a number in it cannot be drawn. RecordError: the file cannot be written.
    """
    for run in runs:
        run.check_poses()
    write_recordings(path, "; ".join(f"{run.title}: {run.end.words}" for run in runs), map(_recording, runs))


class Recording(NamedTuple):
    """What a page plays: title, end, reason and notes, and its frames, with one in `shown` scans."""

    told: Mapping[str, Any]
    frames: Sequence[Frame]
    duration: float  # [s]
    shown: int = 1


def write_recordings(path: Path, title: str, recordings: Iterable[Recording]) -> None:
    """Writes a page with this title that plays recordings; RecordError: the file cannot be written."""
    page = len(one_file(title, []).encode())
    fitting = [fitted(told, frames, largest_file(over) - page, shown) for told, frames, over, shown in recordings]
    with replacing(path) as unfinished:
        unfinished.write_text(one_file(title, fitting), encoding="utf-8", newline="\n")


def _recording(run: RecordedRun) -> Recording:
    try:
        frames = frames_of(run)
    except scene.SceneError as error:
        raise RunError(f"{run.folder}: {error}") from None
    told: dict[str, Any] = {"title": run.title, "end": run.end.words, "reason": run.end.reason}
    told["notes"] = _missing(frames, run.settings.planner)
    return Recording(told, frames, run.log.duration, decimation(run))


def fitted(told: Mapping[str, Any], frames: Sequence[Frame], largest: int, shown: int = 1) -> str:
    """A recording `packed`, with fewer scans, maps and candidates where it would exceed `largest` [bytes]."""
    factor = 1
    text = _packed(told, frames, shown)
    while (size := len(text)) > largest and factor < COARSEST:
        factor *= 2 ** max(1, int(math.log2(size / largest)))
        text = _packed(told, thinned(frames, factor), factor * shown)
    return text


def largest_file(duration: float) -> int:
    """Size that the page of a run of this duration [s] must not exceed [bytes]."""
    return int(min(max(1.0, duration / SHORT) * LARGEST_SHORT, LARGEST))


def _packed(told: Mapping[str, Any], frames: Sequence[Frame], decimation: int) -> str:
    fewer = f"one in {decimation} scans, maps and sets of candidates: all are too many for one file"
    return packed({**told, "notes": [*told["notes"], *([fewer] if decimation > 1 else [])], "frames": frames})


def _missing(frames: Sequence[Frame], planner: Planning) -> list[str]:
    """Returns a note that names the parts of the run that were not recorded; none where nothing is missing."""
    compared = any(frame.get("rollouts") or frame.get("candidates", {}).get("at") for frame in frames)
    remembers = planner.strategy in TIME_TO_GOAL
    known = {
        "free space, frontiers and predicted boundaries": any("free" in frame for frame in frames),
        "what the planner compared": compared,
        "boundaries that it remembered": not remembers or any(frame.get("remembered") for frame in frames),
        "cost terms": any(frame.get("costs", {}).get("terms") for frame in frames),
        "reasons of the controller": any(frame.get("doing", {}).get("reason") for frame in frames),
        "health of the nodes": any(frame.get("nodes") for frame in frames),
    }
    missing = [words for words, is_known in known.items() if not is_known]
    return [f"not recorded: {', '.join(missing)}"] if missing else []
