"""Folders of studies whose rows are made up, without a single run."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from collplan_core.evaluation.impact_matching import DELIBERATE_SPEED
from collplan_study.analysis import statistics
from collplan_study.question.grid import NO_ABLATION, Source, Task, load_sources, make_grid
from collplan_study.question.question import Question
from collplan_study.report import pictures
from collplan_study.report.figures import Picture
from collplan_study.run.rows import ERROR, MEASURES, TrialRow, write_tables
from collplan_study.run.study_folder import make_folder, new_provenance


def without_figures(patch: pytest.MonkeyPatch) -> None:
    """Fewer resamples, and figures made but not rendered, which takes the time."""
    patch.setattr(statistics, "RESAMPLES", 499)
    patch.setattr(pictures, "saved_picture", lambda folder, name, figure, words: Picture("<svg/>", words, name))


Measures = Callable[[Task], dict[str, Any]]
Impacts = Callable[[Task], list[dict[str, Any]]]


def reached(time: float, length: float = 2.0, impacts: int = 1) -> dict[str, Any]:
    return {
        **dict.fromkeys(MEASURES),
        "outcome": "reached",
        "arrival_time_s": time,
        "path_length_m": length,
        "impacts": impacts,
        "deliberate_impacts": 0,
        "unforeseen_impacts": impacts,
        "mean_speed": length / time,
        "max_impact_speed": 0.3,
        "plans": 9,
        "candidates_mean": 80.0,
        "share_free_space": 1.0,
        "share_boundary_following": 0.0,
        "share_flow_through": 0.0,
        "share_stopped": 0.0,
        "plan_time_ms_p50": 0.5,
        "plan_time_ms_p99": 1.0,
        "error": "",
    }


def timed_out() -> dict[str, Any]:
    return {**reached(30.0), "outcome": "timeout"}


def failed() -> dict[str, Any]:
    return {**dict.fromkeys(MEASURES), "outcome": ERROR, "error": "ValueError: <b>&"}


def fake_study(
    out: Path,
    measures: Measures,
    question: Question,
    sources: tuple[Source, ...] | None = None,
    ablations: Any = NO_ABLATION,
    impacts: Impacts = lambda task: [],
) -> Path:
    """The folder of a study whose rows are those that `measures` and `impacts` return for each task."""
    sources = load_sources(question.worlds, None, None) if sources is None else sources
    grid = make_grid(question, sources, ablations)
    provenance = new_provenance(question, sources, ablations, len(grid))
    folder = make_folder(out, provenance, sources)
    write_tables(folder, grid, (_record(task, measures(task), impacts(task)) for task in grid))
    return folder


def impact(speed: float, error: float | None = None) -> dict[str, Any]:
    foreseen = {"direction_error_rad": error, "foreseen_speed": 0.6, "measured_speed": 0.5}
    known = foreseen if error is not None else dict.fromkeys(foreseen)
    deliberate = error is not None and speed > DELIBERATE_SPEED
    flags = {"foreseen": error is not None, "deliberate": deliberate}
    return {"x": 3.0, "y": 3.5, "speed_into": speed, **flags, **known}


def _record(task: Task, measured: dict[str, Any], impacts: list[dict[str, Any]]) -> TrialRow:
    path = {"t_ms": [0, 50], "x": [3000, 3100], "y": [3000, 4000]}
    return {"index": task.index, "row": {**task.labels, **measured}, "path": path, "impacts": impacts}
