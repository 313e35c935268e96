"""The folder of a study, and a study that is checked and loaded, new or from its folder, before the first trial."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from hashlib import sha256
from pathlib import Path
from typing import Any

import polars as pl

from collplan_core.parameters import Settings
from collplan_core.parameters.spec import ParameterError
from collplan_core.worlds import WorldError, read_world, save_world, world_text
from collplan_study.errors import StudyError
from collplan_study.question.grid import ENGINE, NO_ABLATION, Source, Task, load_sources, make_grid
from collplan_study.question.question import PARTS, Question, StudyOptions, question_from
from collplan_study.question.specification import Changes
from collplan_study.run.provenance import git_state, platform_record, trial_code, versions
from collplan_study.run.rows import IMPACTS, TABLE
from omnipuck_sim.robot.engine import check_installed

PROVENANCE, WORLDS, ROWS, REPORT = "provenance.json", "worlds", "trials.jsonl", "report.html"
RUNS = Path("runs")


@dataclass(frozen=True, eq=False)
class Study:
    """A study that is ready to run."""

    grid: tuple[Task, ...]
    sources: tuple[Source, ...]
    provenance: dict[str, Any]
    """Content of provenance.json. Each call of the command that runs trials of the study is one of its `sessions`."""
    folder: Path | None
    """None where it has none yet."""


def prepare(options: StudyOptions) -> Study:
    """The study that the options describe, new or resumed. Writes nothing."""
    try:
        study = _new(options) if options.resume is None else _resumed(options, options.resume)
        if PARTS[options.run]:
            check_installed(study.grid[0].settings.simulator)
    except (WorldError, ParameterError) as error:
        raise StudyError(str(error)) from None
    return study


def _new(options: StudyOptions) -> Study:
    question, out = options.question(), options.out
    if out is not None and (out / PROVENANCE).exists():
        raise StudyError(f"--out {out}: holds a study already, continue it with --resume {out}")
    if out is not None and out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise StudyError(f"--out {out}: exists, expected a new or an empty folder")
    sources = load_sources(question.worlds, question.start, question.goal)
    ablations = question.specification.ablations if question.ablations else NO_ABLATION
    grid = make_grid(question, sources, ablations)
    return Study(grid, sources, new_provenance(question, sources, ablations, len(grid)), None)


def _resumed(options: StudyOptions, folder: Path) -> Study:
    provenance, installed = read_provenance(folder), trial_code()
    try:
        question, code = options.question(question_from(provenance["question"])), provenance["code"].get("trial")
        sources = read_sources(folder, provenance)
        grid = make_grid(question, sources, provenance["ablations"])
    except (AttributeError, KeyError, TypeError) as error:
        raise StudyError(f"{folder}: its provenance was changed ({error}), expected what a study wrote") from None
    if code != installed:  # its rows would not belong to the same table
        other = f"begun with other code or libraries ({code}), here is {installed}"
        raise StudyError(f"{folder}: {other}: begin a new study")
    return Study(grid, sources, provenance, folder)


def new_provenance(question: Question, sources: Sequence[Source], ablations: Changes, trials: int) -> dict[str, Any]:
    """Provenance of a study of so many trials; `parameters` are the defaults, which the question changes."""
    return {
        "results": "simulated",
        "question": asdict(question),
        "sources": [
            {
                "world": source.world.name,
                "family": source.family,
                # numbered, as a world's name may hold characters that a file's must not
                "file": f"{WORLDS}/{number:04d}.yaml",
                "sha256": sha256(world_text(source.world).encode()).hexdigest(),
            }
            for number, source in enumerate(sources)
        ],
        "ablations": {name: dict(changes) for name, changes in ablations.items()},
        "trials": trials,
        "parameters": Settings().with_values({ENGINE: question.engine}).values(),
        "code": {"trial": trial_code(), "git": git_state()},
        "versions": versions(),
        "platform": platform_record(),
        "sessions": [],
    }


def make_folder(out: Path | None, provenance: Mapping[str, Any], sources: Sequence[Source]) -> Path:
    """Makes a study's folder, by default runs/study-<time>. One that has a provenance, written last, can be resumed."""
    folder = out or RUNS / f"study-{datetime.now():%Y-%m-%d_%H-%M-%S}"
    (folder / WORLDS).mkdir(parents=True)
    for source, record in zip(sources, provenance["sources"], strict=True):
        save_world(source.world, folder / record["file"])
    replace_file(folder / PROVENANCE, provenance)
    return folder


def replace_file(path: Path, content: Mapping[str, Any] | str) -> None:
    """Replaces a file by a text, or by a record in JSON, in one atomic step."""
    text = content if isinstance(content, str) else json.dumps(content, indent=2) + "\n"
    part = path.with_name(f".{path.name}.part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)


def read_provenance(folder: Path) -> dict[str, Any]:
    """The provenance of the study in a folder."""
    path = folder / PROVENANCE
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        raise StudyError(f"{path}: cannot be read ({error}), expected what a study wrote") from None


def read_sources(folder: Path, provenance: Mapping[str, Any]) -> tuple[Source, ...]:
    """The worlds of a study as they were when it was started; a WorldError where a file is not as it was written."""
    sources = []
    for record in provenance["sources"]:
        path = folder / record["file"]
        sources.append(Source(read_world(path), record["family"]))
        # one that is cut off at the end of a line is a world too, but another one; version 1.0.0 wrote no checksum
        if record.get("sha256") not in (None, sha256(path.read_bytes()).hexdigest()):
            raise WorldError(f"{path}: cut off or changed, expected the world as the study wrote it")
    return tuple(sources)


@dataclass(frozen=True, eq=False)
class StudyData:
    """A study whose tables were written."""

    folder: Path
    provenance: Mapping[str, Any]
    sources: tuple[Source, ...]
    runs: pl.DataFrame
    impacts: pl.DataFrame


def read_study(folder: Path) -> StudyData:
    """The study in a folder; a StudyError or a WorldError where a file of it is missing or cut off."""
    provenance = read_provenance(folder)
    try:
        runs, impacts = (pl.read_parquet(folder / name) for name in (TABLE, IMPACTS))
    except (OSError, pl.exceptions.PolarsError):
        advice = f"study --resume {folder} makes them anew"
        raise StudyError(f"{folder}: {TABLE} or {IMPACTS} missing or cut off, {advice}") from None
    return StudyData(folder, provenance, read_sources(folder, provenance), runs, impacts)
