"""Started in several processes: nodes that cannot outlive bringup, and are stopped in order; and the nodes' output."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from rcl_interfaces.msg import Log

from collplan_ros.bringup.ending import NodeDied, NodeRefused
from collplan_ros.node_kit.run_node import STARTUP_ERROR

SHOWN = 10  # lines of a node's output that are printed when it has ended
WARN, ERROR = 30, 40
LEVELS = {10: "DEBUG", 20: "INFO", WARN: "WARN", ERROR: "ERROR", 50: "FATAL"}


class NodeLogs:
    """The files NODE.log in a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def path(self, name: str) -> Path:
        """The file of a node."""
        return self._folder / f"{name}.log"

    def append(self, name: str, text: str) -> None:
        """Adds lines to the file of a node."""
        with self.path(name).open("a", encoding="utf-8") as file:
            file.write(text)

    def take(self, message: Log) -> None:
        """Adds a message of /rosout to the file of its node, in the form of ROS."""
        level, at = LEVELS.get(message.level, message.level), message.stamp
        line = f"[{level}] [{at.sec}.{at.nanosec:09d}] [{message.name}]: {message.msg}\n"
        self.append(message.name.rpartition(".")[2], line)

    def last_lines(self, name: str) -> str:
        """The last lines of a node's output, as a message."""
        path = self.path(name)
        lines = path.read_text(errors="replace").splitlines()[-SHOWN:] if path.exists() else []
        return f"last lines of {name}:\n" + "\n".join(f"  {line}" for line in lines or ["(none)"])


STOP_PATIENCE = 5.0  # time after SIGTERM at which a node that still runs is killed [s]
DIES_WITH = """
import ctypes, os, signal, sys
_, parent, *command = sys.argv
# SIGKILL, because a node that hangs would ignore SIGTERM; the setting survives exec
ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
if os.getppid() != int(parent):  # the parent died before prctl took effect
    sys.exit(1)
os.execv(command[0], command)
"""
"""PARENT PROGRAM ARGUMENT ...: becomes a program that the kernel kills when the thread that started this one ends.

A program of its own, because nothing may run between fork and exec in a process that has threads.
"""
# alone and without site-packages: what those do at a start would be done twice
ALONE = (sys.executable, "-I", "-S", "-c")


class Processes:
    """The processes of nodes, by name; the output of each is a file in a folder.

    The kernel kills one when the thread that started it ends, whatever the reason. Each runs in a session of its own:
    Ctrl-C in a terminal reaches only bringup, which then stops the nodes in order.
    """

    def __init__(self, logs: NodeLogs) -> None:
        """`logs` takes the output."""
        self._logs = logs
        self._started: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, name: str, command: Sequence[str]) -> None:
        """Starts the process of a node, in the place of one that has ended."""
        with self._logs.path(name).open("ab") as output:
            self._started[name] = subprocess.Popen(
                [*ALONE, DIES_WITH, str(os.getpid()), *command],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**os.environ, "PYTHONUNBUFFERED": "1"},
                start_new_session=True,
            )

    @property
    def pids(self) -> dict[str, int]:
        """Process id of each node by name."""
        return {name: process.pid for name, process in self._started.items()}

    def runs(self, name: str) -> bool:
        """Returns whether a node's process is still running."""
        return self._started[name].poll() is None

    def check(self, say: Callable[[str], None], dispensable: Mapping[str, str]) -> None:
        """Says the last lines of a node that has ended, and raises NodeDied, or NodeRefused where it was at its start.

        `dispensable` is the part that a run goes on without where a node has ended, by node.
        """
        for name, process in list(self._started.items()):
            code = process.poll()
            if code is None:
                continue
            say(self._logs.last_lines(name))
            ended = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
            if name not in dispensable:
                raise (NodeRefused if code == STARTUP_ERROR else NodeDied)(f"{name} {ended}")
            del self._started[name]
            say(f"{name} {ended}\nthe run goes on without {dispensable[name]}")

    def stop(self, names: Collection[str]) -> None:
        """Asks nodes to stop, and waits until they have, at most STOP_PATIENCE."""
        asked = [process for name, process in self._started.items() if name in names]
        for process in asked:
            process.terminate()
        deadline = time.monotonic() + STOP_PATIENCE
        for process in asked:
            with suppress(subprocess.TimeoutExpired):
                process.wait(max(deadline - time.monotonic(), 0.0))

    def stop_all(self, last: Collection[str] = ()) -> list[str]:
        """Stops the nodes at once, but those called `last` after the others; returns those that had to be killed."""
        self.stop(self._started.keys() - set(last))
        self.stop(self._started)
        stubborn = [name for name in self._started if self.runs(name)]
        for name in self._started:
            self.kill(name)
        return stubborn

    def kill(self, name: str) -> None:
        """Kills a node's process with its children, and reaps it."""
        with suppress(ProcessLookupError):
            os.killpg(self._started[name].pid, signal.SIGKILL)
        self._started[name].wait()
