"""A process per node: found by name, started so that it cannot outlive bringup, stopped in order."""

import ctypes
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from collplan_ros.bringup.failures import NodeDied, StartError

PR_SET_PDEATHSIG = 1
PATIENCE = 5.0
"""A node that has not ended so long after SIGTERM is killed [s]."""
POLL_PERIOD = 0.01
_libc = ctypes.CDLL(None, use_errno=True)


def find_executable(name: str) -> str:
    """Path of a node's program: beside this Python, in the sourced ROS workspaces, or on the PATH.

    Raises:
        StartError: nowhere.
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


def _tied_to(parent: int) -> Callable[[], None]:
    def in_child() -> None:
        # SIGKILL, because a node that hangs would ignore anything milder; it is kept across exec
        _libc.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it died before prctl took effect
            os._exit(1)

    return in_child


class NodeProcess:
    """One running node, with its output in a file.

    The kernel kills it when the thread that started it ends, whatever the reason. It has a session of its own: a
    terminal's Ctrl-C reaches bringup alone, which then stops the nodes in order.
    """

    def __init__(self, name: str, command: Sequence[str], log: Path) -> None:
        """Starts `command`; `log` takes its output."""
        self.name = name
        self._log = log
        with log.open("wb") as output:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**os.environ, "PYTHONUNBUFFERED": "1"},
                start_new_session=True,
                preexec_fn=_tied_to(os.getpid()),
            )

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def running(self) -> bool:
        """Whether it has not ended yet."""
        return self._process.poll() is None

    def check(self) -> None:
        """Notices the end of the process.

        Raises:
            NodeDied: it has ended.
        """
        code = self._process.poll()
        if code is not None:
            raise NodeDied(f"{self.name} {_how_it_ended(code)}; {self.last_lines()}")

    def last_lines(self, count: int = 10) -> str:
        """The end of its output, as a message."""
        lines = self._log.read_text(errors="replace").splitlines()[-count:]
        return "its last lines:\n" + "\n".join(f"  {line}" for line in lines) if lines else "it printed nothing"

    def ask_to_stop(self) -> None:
        """Sends SIGTERM."""
        if self.running:
            self._process.terminate()

    def kill(self) -> None:
        """Sends SIGKILL to it and whatever it started, and reaps it."""
        with suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        self._process.wait()


def _how_it_ended(code: int) -> str:
    return f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"


def stop_all(processes: Sequence[NodeProcess], first: str) -> list[str]:
    """Stops the node called `first`, then all others at once; returns the names of those that had to be killed."""
    _stop([process for process in processes if process.name == first])
    _stop(processes)
    stubborn = [process.name for process in processes if process.running]
    for process in processes:
        process.kill()
    return stubborn


def _stop(processes: Sequence[NodeProcess]) -> None:
    for process in processes:
        process.ask_to_stop()
    deadline = time.monotonic() + PATIENCE
    while any(process.running for process in processes) and time.monotonic() < deadline:
        time.sleep(POLL_PERIOD)
