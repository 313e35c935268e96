"""The reference firmware as a shared library, compiled on first use by the machine's C compiler."""

import ctypes
import hashlib
import os
import shutil
import subprocess
from pathlib import Path

import omnipuck_driver
from collplan_core.jit import cache_folder
from collplan_core.parameters.spec import ParameterError

COMPILER = "cc"
FLAGS = ("-std=c99", "-O2", "-ffreestanding", "-fPIC", "-shared")
NAME = "libomnipuck_firmware.so"


def firmware_sources() -> Path:
    """The folder of the reference firmware; ParameterError: it was not installed."""
    package = Path(omnipuck_driver.__file__).resolve().parent
    for folder in (package.parent / "firmware", package / "firmware"):
        if (folder / "firmware.c").is_file():
            return folder
    raise ParameterError(f"emulator.firmware: got c, expected python: no sources of the firmware beside {package}")


def compiled_firmware() -> ctypes.CDLL:
    """The library; compiled where its sources have changed.

    ParameterError: there are no sources or no compiler, or it refuses them.
    """
    folder = firmware_sources()
    sources = [*sorted(folder.glob("*.c")), *sorted(folder.glob("host/*.c"))]
    headers = [*folder.glob("*.h"), *folder.glob("host/*.h")]
    digest = hashlib.sha256(b"\0".join(path.read_bytes() for path in sorted([*sources, *headers]))).hexdigest()[:16]
    cache = cache_folder(f"firmware-{digest}")
    if cache is None:
        raise ParameterError("emulator.firmware: got c, expected python: no folder can be written for what is compiled")
    # named by its content: one that is damaged is not found
    return ctypes.CDLL(str(_found(cache) or _compile(sources, cache)))


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def _found(cache: Path) -> Path | None:
    return next((path for path in cache.glob(f"*-{NAME}") if path.name == f"{_digest(path)}-{NAME}"), None)


def _compile(sources: list[Path], cache: Path) -> Path:
    compiler = shutil.which(COMPILER)
    if compiler is None:
        raise ParameterError(f"emulator.firmware: got c, expected python: no C compiler, {COMPILER}, on PATH")
    unfinished = cache / f"unfinished.{os.getpid()}"
    done = subprocess.run([compiler, *FLAGS, "-o", unfinished, *sources], capture_output=True, text=True)
    if done.returncode != 0:
        raise ParameterError(f"emulator.firmware: {compiler} refuses the sources: {done.stderr.strip()}")
    # another process may compile the same
    return unfinished.replace(cache / f"{_digest(unfinished)}-{NAME}")
