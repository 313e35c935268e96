"""The peers: programs that are measured beside, in a virtual environment of their own, made on demand."""

import hashlib
import json
import os
import subprocess
import sys
import venv
from pathlib import Path
from typing import Any

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
    """Installs a peer at its pinned version, unless it was installed before.

    Raises:
        PeerError: it cannot be; the message is pip's error.
    """
    pinned = b"".join(path.read_bytes() for path in PINS) + sys.version.encode()
    done = ENVIRONMENT / f".{peer}-{hashlib.sha256(pinned).hexdigest()[:12]}"
    if done.exists():
        return
    print(f"Installing {peer} into {ENVIRONMENT.name} ...", flush=True)
    pins = [part for path in PINS for part in ("-c", path)]
    pip = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--retries", "1", *pins]
    try:
        if not PYTHON.exists():
            venv.create(ENVIRONMENT, with_pip=True)
        for packages in STEPS[peer]:
            subprocess.run([*pip, *packages], capture_output=True, text=True, check=True)
    except OSError as error:
        raise PeerError(f"{ENVIRONMENT.name} cannot be made: {error}") from None
    except subprocess.CalledProcessError as error:
        lines = [line.strip() for line in str(error.stderr or error).splitlines() if line.strip()]
        # the line of pip's or the compiler's output that names the error
        named = [line for line in lines if "error" in line.lower()]
        raise PeerError((named or lines or ["pip failed and said nothing"])[0][:300]) from None
    done.touch()


class Peer:
    """A process in that environment that answers each line of JSON with one, so that rounds can be interleaved."""

    def __enter__(self) -> "Peer":
        environment = {**os.environ, "MPLBACKEND": "Agg", "PYTHONPATH": ""}
        pipes: dict[str, Any] = dict.fromkeys(("stdin", "stdout"), subprocess.PIPE)
        command = [PYTHON, HERE / "peer_server.py"]
        self._process = subprocess.Popen(command, **pipes, stderr=subprocess.DEVNULL, text=True, env=environment)
        return self

    def __exit__(self, *exception: object) -> None:
        self._process.kill()
        self._process.communicate()

    def ask(self, what: str, **arguments: Any) -> Any:
        """Sends a request and returns its answer.

        Raises:
            PeerError: the peer failed or ended.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps({"what": what, **arguments}) + "\n")
            self._process.stdin.flush()
            answer = json.loads(self._process.stdout.readline())
        except (BrokenPipeError, json.JSONDecodeError):
            raise PeerError(f"the peers' process ended with code {self._process.wait()}") from None
        if "error" in answer:
            raise PeerError(answer["error"])
        return answer["result"]
