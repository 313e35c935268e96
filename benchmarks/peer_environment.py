"""The peers' virtual environment, made on demand: the project does not depend on the peers."""

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
    # its setup.py imports build dependencies that it does not declare: install them first, build without isolation
    "dynamic-window-approach": [
        ["cython", "numpy", "setuptools", "wheel"],
        ["--no-build-isolation", "--no-deps", "dynamic-window-approach"],
    ],
}


class PeerError(RuntimeError):
    """A peer cannot be installed or run; the message gives the reason."""


def install(peer: str) -> None:
    """Install a peer at its pinned version, unless it was installed before.

    Raises:
        PeerError: pip failed; the message is its error.
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
    """Hash over the pins and the version of Python, which identifies an installation."""
    text = b"".join(path.read_bytes() for path in PINS) + sys.version.encode()
    return hashlib.sha256(text).hexdigest()[:12]
