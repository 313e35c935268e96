"""Processes of nodes: found by name, started such that they cannot outlive bringup, stopped in order."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Collection, Sequence
from contextlib import suppress
from pathlib import Path

from collplan_ros.bringup import die_with_parent
from collplan_ros.bringup.failures import NodeDied, StartError

PATIENCE = 5.0
"""Time after SIGTERM at which a node that still runs is killed [s]."""
POLL_PERIOD = 0.01
# alone and without site-packages: what those do at a start would be done twice
_DIES_WITH = (sys.executable, "-I", "-S", die_with_parent.__file__)


def find_executable(name: str) -> str:
    """Path of a node's executable: beside this Python, in the sourced ROS workspaces, or on the PATH.

    Raises:
        StartError: it is in none of these.
    """
    folders = [Path(sys.executable).parent]
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        folders += sorted(Path(prefix, "lib").glob("*/"))
    for folder in folders:
        if os.access(folder / name, os.X_OK) and (folder / name).is_file():
            return str(folder / name)
    found = shutil.which(name)
    if found is None:
        raise StartError(
            f"{name}: no such program beside {sys.executable}, in AMENT_PREFIX_PATH or on PATH; "
            "is its package installed?"
        )
    return found


class NodeProcess:
    """Process of one node, with its output in a file.

    The kernel kills it when the thread that started it ends, whatever the reason. It runs in a session of its own:
    Ctrl-C in a terminal reaches only bringup, which then stops the nodes in order.
    """

    def __init__(self, name: str, command: Sequence[str], log: Path) -> None:
        """Starts `command` with its output written to the file `log`."""
        self.name = name
        self._log = log
        with log.open("wb") as output:
            self._process = subprocess.Popen(
                [*_DIES_WITH, str(os.getpid()), *command],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**os.environ, "PYTHONUNBUFFERED": "1"},
                start_new_session=True,
            )

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def running(self) -> bool:
        """Whether the process has not ended yet."""
        return self._process.poll() is None

    def check(self) -> None:
        """Checks that the process still runs.

        Raises:
            NodeDied: it has ended.
        """
        code = self._process.poll()
        if code is not None:
            raise NodeDied(f"{self.name} {_how_it_ended(code)}")

    def last_lines(self, count: int = 10) -> str:
        """The last lines of the process's output, as a message."""
        lines = self._log.read_text(errors="replace").splitlines()[-count:]
        return f"last lines of {self.name}:\n" + "\n".join(f"  {line}" for line in lines or ["(none)"])

    def ask_to_stop(self) -> None:
        """Sends SIGTERM if the process still runs."""
        if self.running:
            self._process.terminate()

    def kill(self) -> None:
        """Sends SIGKILL to the process and its children, and reaps it."""
        with suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        self._process.wait()


def _how_it_ended(code: int) -> str:
    return f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"


def stop_all(processes: Sequence[NodeProcess], last: Collection[str] = ()) -> list[str]:
    """Stops the nodes at once, but those called `last` after the others.

    Returns:
        The names of those that had to be killed.
    """
    stop([process for process in processes if process.name not in last])
    stop(processes)
    stubborn = [process.name for process in processes if process.running]
    for process in processes:
        process.kill()
    return stubborn


def stop(processes: Sequence[NodeProcess]) -> None:
    """Asks processes to stop, and waits until they have, at most PATIENCE."""
    for process in processes:
        process.ask_to_stop()
    deadline = time.monotonic() + PATIENCE
    while any(process.running for process in processes) and time.monotonic() < deadline:
        time.sleep(POLL_PERIOD)
