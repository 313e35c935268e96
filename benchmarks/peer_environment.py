"""The peers' own environment, made on demand: nothing of it is a dependency of the project."""

import hashlib
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ENVIRONMENT = HERE.parent / ".venv-bench"
PYTHON = ENVIRONMENT / "bin" / "python"
PINS = (HERE.parent / "constraints.txt", HERE / "requirements-peers.txt")
STEPS: dict[str, list[list[str]]] = {
    "ir-sim": [["ir-sim"]],
    # its setup.py imports what it builds with, and says so nowhere: no isolation, and those first
    "dynamic-window-approach": [
        ["cython", "numpy", "setuptools", "wheel"],
        ["--no-build-isolation", "--no-deps", "dynamic-window-approach"],
    ],
}


class PeerError(RuntimeError):
    """A peer that cannot be installed or run; the message says why."""


def install(peer: str) -> None:
    """Install a peer at its pinned version, once.

    Raises:
        PeerError: with pip's own reason.
    """
    done = ENVIRONMENT / f".{peer}-{_digest()}"
    if done.exists():
        return
    print(f"Installing {peer} into {ENVIRONMENT.name} ...", flush=True)
    if not PYTHON.exists():
        _make_environment()
    for packages in STEPS[peer]:
        _pip(packages)
    done.touch()


def _make_environment() -> None:
    try:
        venv.create(ENVIRONMENT, with_pip=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise PeerError(f"{ENVIRONMENT.name} cannot be made: {error}") from None


def _pip(packages: list[str]) -> None:
    pins = [part for path in PINS for part in ("-c", str(path))]
    command = [str(PYTHON), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--retries", "1"]
    done = subprocess.run([*command, *pins, *packages], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise PeerError(_reason(done.stderr))


def _reason(output: str) -> str:
    """The line of pip's or the compiler's output that names the error."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    errors = [line for line in lines if "error" in line.lower()]
    return (errors or lines or ["pip failed and said nothing"])[0][:300]


def _digest() -> str:
    """Over the pins and the Python: another version of either is another installation."""
    text = b"".join(path.read_bytes() for path in PINS) + sys.version.encode()
    return hashlib.sha256(text).hexdigest()[:12]
