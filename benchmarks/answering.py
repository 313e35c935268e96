"""Requests to another process, one line of JSON each way, so that rounds of two programs can take turns."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent


class SkippedError(RuntimeError):
    """Something cannot be measured beside; the message gives the reason."""


Ask = Callable[..., Any]
"""Sends a request, its name and its arguments, and returns the answer. Raises SkippedError where there is none."""


@contextmanager
def answering(python: Path | str, script: str, python_path: str = "") -> Iterator[Ask]:
    """Runs a script of this folder, with a PYTHONPATH, until the block ends."""
    environment = {**os.environ, "MPLBACKEND": "Agg", "PYTHONPATH": python_path}
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen([python, HERE / script], **pipes, text=True, env=environment)

    def ask(what: str, **arguments: Any) -> Any:
        try:
            process.stdin.write(json.dumps({"what": what, **arguments}) + "\n")
            process.stdin.flush()
            answer = json.loads(process.stdout.readline())
        except (BrokenPipeError, json.JSONDecodeError):
            raise SkippedError(f"its process ended with code {process.wait()}") from None
        if "error" in answer:
            raise SkippedError(answer["error"])
        return answer["result"]

    try:
        yield ask
    finally:
        process.kill()
        process.communicate()


def serve(requests: Mapping[str, Callable[..., Any]]) -> None:
    """The other side: answers each request by the function of its name until stdin ends."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # stdout carries answers alone; what a program prints goes to stderr
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = {"result": requests[request.pop("what")](**request)}
        except Exception as error:  # any error is reported as the reason to skip what is measured
            answer = {"error": f"{type(error).__name__}: {error}"}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()
