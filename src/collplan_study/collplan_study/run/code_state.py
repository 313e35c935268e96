"""Which code makes the rows."""

import subprocess
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import omnipuck_sim
from collplan_core.jit import sources_digest

SIMULATOR = Path(omnipuck_sim.__file__).parent
LIBRARIES = ("numpy", "scipy", "shapely", "numba", "llvmlite", "pymunk", "PyYAML", "pyarrow", "distributed")
PROJECT = ("collplan-core", "omnipuck-sim", "collplan-study")


def trial_code() -> str:
    """Hash over all that decides a trial's result: planner, simulator, and the libraries that calculate for them."""
    digest = sha256(sources_digest().encode())
    for path in sorted(SIMULATOR.rglob("*.py")):
        digest.update(path.relative_to(SIMULATOR).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    digest.update("".join(version(name) for name in ("numpy", "numba", "pymunk")).encode())
    return digest.hexdigest()[:16]


def versions() -> dict[str, str]:
    """Of the project's packages and of the libraries that are installed."""
    return {name: found for name in PROJECT + LIBRARIES if (found := _version(name))}


def git_state() -> str | None:
    """What git says of the sources' commit and changes to it; None where they are in no repository."""
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
