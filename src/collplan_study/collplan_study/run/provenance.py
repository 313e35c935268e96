"""Where rows come from: the code that ran them, its version and libraries, and the machine."""

import os
import platform
import subprocess
from contextlib import suppress
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import omnipuck_sim
from collplan_core.jit import sources_digest
from collplan_study.run import rows

SIMULATOR, COLUMNS = Path(omnipuck_sim.__file__).parent, Path(rows.__file__)
PROJECT = ["collplan-core", "omnipuck-sim", "collplan-study"]
LIBRARIES = ["numpy", "scipy", "shapely", "numba", "llvmlite", "pymunk", "mujoco-core", "polars", "distributed"]


def trial_code() -> str:
    """Hash over all that decides a trial's row: collplan_core, the simulator, the columns, and the libraries."""
    libraries = [versions().get(name, "") for name in ("numpy", "numba", "pymunk", "mujoco-core")]
    sources = [sources_digest(), sources_digest(SIMULATOR), COLUMNS.read_text(encoding="utf-8")]
    return sha256("".join([*sources, *libraries]).encode()).hexdigest()[:16]


def git_state() -> str | None:
    """Commit of the sources as `git describe` prints it, with -dirty for changes; None outside a repository."""
    command = ["git", "-C", str(SIMULATOR), "describe", "--always", "--dirty", "--abbrev=12"]
    with suppress(OSError, subprocess.SubprocessError):
        return subprocess.run(command, capture_output=True, text=True, timeout=10.0, check=True).stdout.strip()
    return None


def versions() -> dict[str, str]:
    """Version of each package of the project and of each library that is installed."""
    found = {}
    for name in PROJECT + LIBRARIES:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def platform_record() -> dict[str, Any]:
    """The Python, system, machine, processor and number of processors that a run has."""
    names = []
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return {
        "python": platform.python_version(),
        "system": platform.platform(),
        "machine": platform.machine(),
        "processor": names[0] if names else platform.processor(),
        "cpus": os.cpu_count(),
    }
