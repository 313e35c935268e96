"""The peers: programs that are measured beside, in a virtual environment of their own, made on demand."""

import subprocess
import venv
from contextlib import AbstractContextManager

from answering import HERE, Ask, SkippedError, answering

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


def peer(name: str) -> AbstractContextManager[Ask]:
    """A process in that environment, with a peer installed by name; SkippedError with pip's error if it cannot be."""
    _install(name)
    return answering(PYTHON, "peer_server.py")


def _install(peer: str) -> None:
    """Installs a peer at its pinned version; pip asks no index for what is there."""
    print(f"{peer} in {ENVIRONMENT.name} ...", flush=True)
    pins = [part for path in PINS for part in ("-c", path)]
    pip = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--retries", "1", *pins]
    try:
        if not PYTHON.exists():
            venv.create(ENVIRONMENT, with_pip=True)
        for packages in STEPS[peer]:
            subprocess.run([*pip, *packages], capture_output=True, text=True, check=True)
    except OSError as error:
        raise SkippedError(f"{ENVIRONMENT.name} cannot be made: {error}") from None
    except subprocess.CalledProcessError as error:
        # the line of pip's or the compiler's output that names the error
        named = [line.strip() for line in str(error.stderr).splitlines() if "error" in line.lower()]
        raise SkippedError((named or ["pip failed and said nothing"])[0][:300]) from None
