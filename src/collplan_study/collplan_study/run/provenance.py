"""The provenance of a study: its question, code, machine, and times of running.

A study may take several invocations of the command, one that starts it and others that resume it. Each invocation is
recorded as one session.
"""

import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import omnipuck_sim
from collplan_core.jit import sources_digest
from collplan_core.parameters import Settings
from collplan_study.errors import StudyError
from collplan_study.question.grid import ENGINE
from collplan_study.question.options import StudyOptions
from collplan_study.question.question import Question
from collplan_study.question.sources import Source
from collplan_study.run.study_folder import source_records
from collplan_study.tables import rows

Provenance = dict[str, Any]
SIMULATOR = Path(omnipuck_sim.__file__).parent
TABLES = Path(rows.__file__).parent
LIBRARIES = (
    "numpy",
    "scipy",
    "shapely",
    "numba",
    "llvmlite",
    "pymunk",
    "mujoco-core",
    "PyYAML",
    "pyarrow",
    "distributed",
)
PROJECT = ("collplan-core", "omnipuck-sim", "collplan-study")


def trial_code() -> str:
    """Hash over all that decides a trial's row: collplan_core, the simulator, the columns, and the libraries.

    It covers every Python file of the two packages and of `tables`, in subfolders too.
    """
    libraries = [version(name) for name in ("numpy", "numba", "pymunk")] + [_version("mujoco-core") or ""]
    sources = [sources_digest(), sources_digest(SIMULATOR), sources_digest(TABLES)]
    return sha256("".join([*sources, *libraries]).encode()).hexdigest()[:16]


def git_state() -> str | None:
    """Commit of the sources as `git describe` prints it, with -dirty for changes; None outside a repository."""
    command = ["git", "-C", str(SIMULATOR), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10.0, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def new_provenance(
    question: Question, sources: Sequence[Source], ablations: Mapping[str, Mapping[str, Any]], trials: int
) -> Provenance:
    """Provenance of a study of `trials` trials, before the first of them; its list of sessions is empty.

    `parameters` are the defaults with the requested engine; `question`, `sources` and `ablations` hold the changes in
    the cells of the grid.
    """
    return {
        "results": "simulated",
        "question": question.record(),
        "sources": source_records(sources),
        "ablations": {name: dict(changes) for name, changes in ablations.items()},
        "trials": trials,
        "parameters": Settings().with_values({ENGINE: question.engine}).values(),
        "code": {"trial": trial_code(), "git": git_state()},
        "versions": {name: found for name in PROJECT + LIBRARIES if (found := _version(name))},
        "platform": platform_record(),
        "sessions": [],
    }


def new_session(options: StudyOptions, done: int) -> dict[str, Any]:
    """Record of an invocation that starts now.

    Args:
        options: options of the command line.
        done: trials that earlier sessions completed.
    """
    where = {"jobs": options.jobs} if options.dask is None else {"dask": options.dask}
    command = shlex.join([os.path.basename(sys.argv[0]), *sys.argv[1:]])
    return {"command": command, **where, "begun": _now(), "done_before": done}


def finished_session(session: Mapping[str, Any], trials: int, wall_time: float) -> dict[str, Any]:
    """Record of a session that ends now and has run `trials` trials in `wall_time` [s]."""
    return {**session, "ended": _now(), "trials": trials, "wall_time_s": round(wall_time, 3)}


def check_code(provenance: Provenance, folder: Path) -> None:
    """Refuses to resume a study with other code: its rows would not belong to the same table.

    Raises:
        StudyError: the installed code is not the code that the study in `folder` was started with.
    """
    recorded, installed = provenance["code"].get("trial"), trial_code()
    if recorded != installed:
        raise StudyError(
            f"{folder}: begun with other code or libraries ({recorded}), here is {installed}: begin a new study"
        )


def _now() -> str:
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def platform_record() -> dict[str, Any]:
    """Returns the Python, system, machine, processor and number of processors that a run has."""
    return {
        "python": platform.python_version(),
        "system": platform.platform(),
        "machine": platform.machine(),
        "processor": _processor(),
        "cpus": os.cpu_count(),
    }


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            names = [line.partition(":")[2].strip() for line in file if line.startswith("model name")]
    except OSError:
        names = []
    return names[0] if names else platform.processor()
