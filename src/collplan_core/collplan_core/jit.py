"""Compiled loops, with a cache that notices every change and every damage.

numba's file cache looks at one file at a time and returns stale code when a called function in another file has
changed. The cache folder is therefore named by a hash over all sources of this package and numba's version. numba runs
the code found there, so only the user can access the folder.
"""

import hashlib
import os
import pickle
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.serialize import dumps
from numba.extending import register_jitable

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
    if os.name != "posix":  # a user's folders are closed to others there
        return path
    found = path.lstat()  # a link may lead to another user's file
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid():
        raise PermissionError(f"{path}: expected a folder of user {os.getuid()}, and no link")
    if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        shutil.rmtree(path, ignore_errors=True)
        path.mkdir(mode=0o700, exist_ok=True)
    path.chmod(0o700)
    if not os.access(path, os.W_OK | os.X_OK):
        raise PermissionError(f"{path}: cannot be written")
    return path


def cache_folder(name: str) -> Path | None:
    """A folder for what is compiled on this machine, the user's alone; None where nothing can be written."""
    for parent in _parents():
        with suppress(OSError):
            return private_folder(private_folder(parent) / name)
    with suppress(OSError):
        return Path(tempfile.mkdtemp(prefix="collplan-"))
    return None


def _parents() -> Iterator[Path]:
    """Folders in which a cache may be, the best first; a relative one counts as not set (XDG base directories)."""
    if os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(os.environ["NUMBA_CACHE_DIR"]).absolute() / "collplan"
    home = os.path.expanduser("~/.cache") if os.environ.get("HOME") != "" else ""
    for cache in (os.environ.get("XDG_CACHE_HOME", ""), home):
        if Path(cache).is_absolute():
            yield Path(cache) / "collplan"
    with suppress(OSError):
        yield Path(tempfile.gettempdir()) / f"collplan-{os.getuid() if os.name == 'posix' else 'cache'}"


CACHE = cache_folder(f"numba-{sources_digest()}")


class _Checked(CompileResultCacheImpl):
    """Compiled code with its checksum: damaged code could do anything."""

    def reduce(self, cres: Any) -> tuple[bytes, bytes]:
        body = dumps(super().reduce(cres))
        return hashlib.sha256(body).digest(), body

    def rebuild(self, target_context: Any, payload: tuple[bytes, bytes]) -> Any:
        digest, body = payload
        if hashlib.sha256(body).digest() != digest:
            raise ValueError("damaged")
        return super().rebuild(target_context, pickle.loads(body))


class _Cache(FunctionCache):
    """Compiles anew what cannot be read, and goes on where nothing can be written.

    Two processes that save at once can each take the same name for code of other argument types. Such code is not run.
    """

    _impl_class = _Checked

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            found = super().load_overload(sig, target_context)
            return found if found is None or found.signature.args == tuple(sig) else None
        except Exception:  # whatever damaged bytes lead to
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        with suppress(Exception):  # also what a damaged index that cannot be removed leads to
            super().save_overload(sig, data)


def njit(function: Any) -> Any:
    """numba's nopython compiler, cached, without reordering of floating point (runs must be bit-reproducible).

    Compiled code lets the other threads of Python run: a planner's heartbeat goes on while it plans.
    """
    compiled = numba.njit(nogil=True)(function)
    if CACHE is None or not hasattr(compiled, "enable_caching"):  # NUMBA_DISABLE_JIT
        return compiled
    # the user's own functions go on using the user's own folder
    users, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(CACHE)
    try:
        compiled._cache = _Cache(function)  # noqa: SLF001 (numba has no other way to be given one)
    finally:
        numba.config.CACHE_DIR = users
    return compiled


def jitable(function: Any) -> Any:
    """A function that compiled code may call too; Python calls it as it is, without compiling it first."""
    return register_jitable(function)
