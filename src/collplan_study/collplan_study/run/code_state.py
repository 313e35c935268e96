"""Identifies the code that makes a study's rows: a hash, the commit, and the versions of packages."""

import subprocess
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import omnipuck_sim
from collplan_core.jit import sources_digest

SIMULATOR = Path(omnipuck_sim.__file__).parent
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
    """Hash over all that decides a trial's result: collplan_core, the simulator, and the libraries they calculate with.

    It covers every Python file of the two packages, in subfolders too.
    """
    libraries = [version(name) for name in ("numpy", "numba", "pymunk")] + [_version("mujoco-core") or ""]
    return sha256("".join([sources_digest(), sources_digest(SIMULATOR), *libraries]).encode()).hexdigest()[:16]


def versions() -> dict[str, str]:
    """Version by name of the project's packages and of the libraries that are installed."""
    return {name: found for name in PROJECT + LIBRARIES if (found := _version(name))}


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
