"""The folder of a study: its provenance, its worlds, its trials."""

import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import datetime
from hashlib import sha256
from itertools import count
from pathlib import Path
from typing import Any

from collplan_core.worlds import World, WorldError, save_world
from collplan_core.worlds.file import read_world, world_text
from collplan_study.errors import StudyError
from collplan_study.question.sources import Source

PROVENANCE, WORLDS, ROWS, REPORT = "provenance.json", "worlds", "trials.jsonl", "report.html"
RUNS = Path("runs")
REQUIRED = frozenset({"question", "sources", "ablations", "code", "sessions"})
"""Keys of a provenance that resuming a study needs."""


def check_new(out: Path | None) -> None:
    """Refuses a folder for a new study that exists and is not empty.

    Raises:
        StudyError: it does; it is left as it is.
    """
    if out is None or not out.exists():
        return
    if (out / PROVENANCE).exists():
        raise StudyError(f"--out {out}: holds a study already, continue it with --resume {out}")
    if not out.is_dir() or any(out.iterdir()):
        raise StudyError(f"--out {out}: exists, expected a new or an empty folder")


def make_folder(out: Path | None, provenance: Mapping[str, Any], sources: Sequence[Source]) -> Path:
    """Makes a study's folder.

    Its provenance is written last and in one atomic step: a folder that has it can be resumed.

    Args:
        out: path of the folder, new or empty; None is runs/study-<time>.
        provenance: content of provenance.json.
        sources: the worlds of the study.

    Raises:
        StudyError: the folder cannot be written.
    """
    try:
        folder = _new_folder() if out is None else out
        (folder / WORLDS).mkdir(parents=True)
        for number, source in enumerate(sources):
            save_world(source.world, folder / _file(number))
        write_provenance(folder, provenance)
    except OSError as error:
        raise StudyError(f"{out or RUNS}: cannot be written: {error.strerror or error}") from None
    return folder


def write_provenance(folder: Path, provenance: Mapping[str, Any]) -> None:
    """Replaces provenance.json in one atomic step."""
    part = folder / f".{PROVENANCE}.part"
    part.write_text(json.dumps(provenance, indent=2) + "\n", encoding="utf-8")
    os.replace(part, folder / PROVENANCE)


def read_provenance(folder: Path) -> dict[str, Any]:
    """The provenance of the study in a folder.

    Raises:
        StudyError: provenance.json is missing or is not that of a study.
    """
    path = folder / PROVENANCE
    try:
        provenance = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise StudyError(f"{path}: cannot be read ({error.strerror}), expected the folder of a study") from None
    except ValueError as error:
        raise StudyError(f"{path}: not JSON ({error}), expected what a study wrote") from None
    if not isinstance(provenance, dict) or not provenance.keys() >= REQUIRED:
        raise StudyError(f"{path}: not of a study, expected what one wrote")
    return provenance


def read_sources(folder: Path, provenance: Mapping[str, Any]) -> tuple[Source, ...]:
    """The worlds of a study as they were when it was started.

    Raises:
        WorldError: a world file cannot be read, or is not as the study wrote it.
    """
    return tuple(Source(_written_world(folder, each), each["family"]) for each in provenance["sources"])


def _written_world(folder: Path, record: Mapping[str, Any]) -> World:
    path = folder / record["file"]
    world = read_world(path)
    # one that is cut off at the end of a line is a world too, but another one; version 1.0.0 wrote no checksum
    if record.get("sha256") not in (None, sha256(path.read_bytes()).hexdigest()):
        raise WorldError(f"{path}: cut off or changed, expected the world as the study wrote it")
    return world


def source_records(sources: Sequence[Source]) -> list[dict[str, Any]]:
    """The sources as JSON holds them; each world is in a file of its own."""
    return [
        {
            "world": source.world.name,
            "family": source.family,
            "file": _file(number),
            "sha256": sha256(world_text(source.world).encode()).hexdigest(),
        }
        for number, source in enumerate(sources)
    ]


def _file(number: int) -> str:
    # numbered, as a world's name may hold characters that a file's must not
    return f"{WORLDS}/{number:04d}.yaml"


def _new_folder() -> Path:
    """A folder of this second's name that no other study has taken."""
    stem = f"study-{datetime.now():%Y-%m-%d_%H-%M-%S}"
    for path in (RUNS / (stem if number == 1 else f"{stem}_{number}") for number in count(1)):
        with suppress(FileExistsError):
            path.mkdir(parents=True)
            return path
    raise AssertionError("unreachable")
