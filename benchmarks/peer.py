"""A process in the peers' environment that answers each line of JSON with a line of JSON."""

import json
import os
import subprocess
from pathlib import Path
from typing import Any

from peer_environment import PYTHON, PeerError

SERVER = Path(__file__).resolve().parent / "peer_server.py"


class Peer:
    """The running process; it is asked for one round at a time, so that rounds can be interleaved."""

    def __enter__(self) -> "Peer":
        environment = {**os.environ, "MPLBACKEND": "Agg", "PYTHONPATH": ""}
        self._process = subprocess.Popen(
            [PYTHON, SERVER],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=environment,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._requests, self._answers = self._process.stdin, self._process.stdout
        return self

    def __exit__(self, kind: Any, value: Any, trace: Any) -> None:
        self._requests.close()
        try:
            self._process.wait(timeout=5.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def ask(self, what: str, **arguments: Any) -> Any:
        """Sends a request and returns its answer.

        Raises:
            PeerError: the peer failed or ended.
        """
        try:
            self._requests.write(json.dumps({"what": what, **arguments}) + "\n")
            self._requests.flush()
        except BrokenPipeError:
            raise PeerError("the peers' process has ended") from None
        line = self._answers.readline()
        if not line:
            raise PeerError(f"the peers' process ended with code {self._process.wait()}")
        answer = json.loads(line)
        if "error" in answer:
            raise PeerError(answer["error"])
        return answer["result"]
