"""Compiled loops, with a cache that notices every change.

numba's file cache looks at one file at a time and returns stale code when a called function in another file has
changed. The cache folder is therefore named by a hash over all sources of this package and numba's version. numba runs
the code found there, so only the user can access the folder.
"""

import hashlib
import os
import shutil
import stat
import tempfile
from importlib.metadata import version
from pathlib import Path
from typing import Any

PACKAGE = Path(__file__).parent


def sources_digest(package: Path = PACKAGE) -> str:
    """Hash over name and text of every Python file of the package and the version of numba."""
    digest = hashlib.sha256(version("numba").encode())
    for path in sorted(package.rglob("*.py")):
        digest.update(path.relative_to(package).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def private_folder(path: Path) -> Path:
    """Makes a folder that nobody but this user can read or write, or empties and closes one that others could write.

    Raises:
        OSError: it cannot be made, is no folder, or belongs to another user.
    """
    path.mkdir(mode=0o700, parents=True, exist_ok=True)
    found = path.lstat()  # a link may lead to another user's file
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid():
        raise PermissionError(f"{path}: expected a folder of user {os.getuid()}, and no link")
    if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        shutil.rmtree(path, ignore_errors=True)
        path.mkdir(mode=0o700, exist_ok=True)
    path.chmod(0o700)
    return path


def cache_folder(name: str) -> str:
    """A folder for what is compiled on this machine, the user's alone."""
    home = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    for parent in (home / "collplan", Path(tempfile.gettempdir()) / f"collplan-{os.getuid()}"):
        try:
            return str(private_folder(private_folder(parent) / name))
        except OSError:
            continue
    return tempfile.mkdtemp(prefix="collplan-")


os.environ["NUMBA_CACHE_DIR"] = cache_folder(f"numba-{sources_digest()}")

import numba  # noqa: E402  (reads NUMBA_CACHE_DIR when imported)
from numba.extending import register_jitable  # noqa: E402

# another import of numba may have come first and read the variable before it was set
numba.config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"]


def njit(function: Any) -> Any:
    """numba's nopython compiler, cached, without reordering of floating point (runs must be bit-reproducible).

    Compiled code lets the other threads of Python run: a planner's heartbeat goes on while it plans.
    """
    return numba.njit(cache=True, nogil=True)(function)


def jitable(function: Any) -> Any:
    """A function that compiled code may call too; Python calls it as it is, without compiling it first."""
    return register_jitable(function)
