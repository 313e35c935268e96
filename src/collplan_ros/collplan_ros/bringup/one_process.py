"""Started in one process: the nodes of a simulated robot, for which simulated time waits, pose by pose.

Within a process DDS delivers in `publish`, so nothing is under way once no node has anything left to do. Equal seeds
then give equal runs, however busy the machine is.
"""

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from pkgutil import resolve_name
from types import FrameType
from typing import Any

from rclpy.executors import Executor
from rclpy.node import Node

from collplan_ros.bringup.ending import GRAPH_LOST, NodeDied
from collplan_ros.bringup.options import SIMULATOR
from collplan_ros.node_kit.events_executor import events_executor, run_all_due

HANG_LOOKS = 10
"""Looks after which a callback counts as one that does not return; the longest plan takes some tenths of a second."""
LOOK_PERIOD = 1.0
"""Between two looks [s]. Looks are counted, not seconds: after a stop of the whole process there is one."""
SIGNAL = signal.SIGUSR1  # interrupts the main thread


class Hangs(BaseException):
    """Raised in a callback that does not return. No `Exception`: a callback that handles those must end, too."""


class HangWatch:
    """Watches the callbacks of the main thread. In another thread it does nothing, as signals do not reach that."""

    def __init__(self) -> None:
        self.name, self._turn, self._overdue = "", 0, -1
        self._ended = threading.Event()

    def begin(self, name: str) -> None:
        """Notes that a callback of this node begins; `name` is "" again once it has returned."""
        self._turn, self.name = self._turn + 1, name

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Raises Hangs in a callback that does not return, until left.

        One that does not even get back to Python then, as compiled code may, ends the process.
        """
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = signal.signal(SIGNAL, self._interrupt)
        thread = threading.Thread(target=self._look, name="hang watch", daemon=True)
        thread.start()
        try:
            yield
        finally:
            self._ended.set()
            thread.join()
            signal.signal(SIGNAL, before)

    def _look(self) -> None:
        seen, looks = -1, 0
        while not self._ended.wait(LOOK_PERIOD):
            turn = self._turn
            seen, looks = turn, looks + 1 if self.name and turn == seen else 0
            if looks == HANG_LOOKS:
                self._overdue = turn
                signal.pthread_kill(threading.main_thread().ident or 0, SIGNAL)
            elif looks == 2 * HANG_LOOKS:
                print(f"bringup: {self.name} hangs: its process ends", file=sys.stderr, flush=True)
                os._exit(GRAPH_LOST)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        if self.name and self._turn == self._overdue:
            raise Hangs


CLASSES = {
    SIMULATOR: "omnipuck_sim.node.simulator_node:SimulatorNode",
    "mocap_node": "collplan_ros.nodes.mocap_node:MocapNode",
    "lidar_node": "collplan_ros.nodes.lidar_node:LidarNode",
    "planner_node": "collplan_ros.nodes.planner_node:PlannerNode",
    "controller_node": "collplan_ros.nodes.controller_node:ControllerNode",
}
"""Where the class of each node is; names, so that this package does not depend on the simulator's."""
STANDING_PERIOD = 0.002
"""Pause between two looks at the nodes while time stands still [s]: other processes may be discovered meanwhile."""
CATCH_UP = 0.25  # time behind real time that is made up for [s]; more is given up
Died = Callable[[str, BaseException], NodeDied]
"""Makes the error for a node, by its name, that has raised."""


class SteppedNodes:
    """Nodes in this process, each with an executor of its own, run one after the other in the calling thread."""

    def __init__(self, own: Node, own_executor: Executor, died: Died, in_real_time: bool) -> None:
        """Makes no node yet; bringup's `own` is run in turn with the others. Real time may bound simulated time."""
        self.time_runs = False
        """Whether simulated time passes in each step; ends with the simulator."""
        self._context = own.context
        self._nodes: dict[str, Any] = {own.get_name(): own}
        self._executors = {own.get_name(): own_executor}
        self._died = died
        self._watch = HangWatch()
        self.watching = self._watch.watching
        self._in_real_time = in_real_time
        self._due = self._time = 0.0

    def start(self, name: str, arguments: Sequence[str]) -> None:
        """Makes a node with its command-line arguments, or raises NodeDied."""
        try:
            node = resolve_name(CLASSES[name])(context=self._context, cli_args=list(arguments))
        except Exception as error:
            died = self._died(name, error)
        else:
            self._nodes[name], self._executors[name] = node, events_executor(self._context)
            self._executors[name].add_node(node)
            return
        gc.collect()  # what was made of it would stay in the domain
        raise died

    def let_time_run(self) -> None:
        """Lets simulated time pass in each step from now on; until then it stands still."""
        self.time_runs, self._due = True, time.monotonic()

    def now(self) -> float:
        """The time for patience [s]: simulated time once that runs, since nodes may take as long as they need."""
        return self._time if self.time_runs else time.monotonic()

    def step(self) -> None:
        """Lets time pass until a pose is there, and runs the nodes until none has work left.

        NodeDied: one has raised, or does not return.
        """
        if not self.time_runs:
            time.sleep(STANDING_PERIOD)
        else:
            self._grant()
        while sum(map(self._has_run, tuple(self._executors))):
            pass

    def stop(self, names: Collection[str]) -> None:
        """Stops nodes as the end of their process would; what one raises then is in its log alone."""
        for name in [name for name in self._nodes if name in names]:
            node = self._nodes[name]
            with suppress(NodeDied):
                self._run(name, getattr(node, "stop", lambda: None))
                self._drop(name)

    def _grant(self) -> None:
        before = self._time
        if self._in_real_time:
            ahead = self._due - time.monotonic()
            time.sleep(max(ahead, 0.0))
            self._due += max(-ahead - CATCH_UP, 0.0)
        self._time = self._run(SIMULATOR, self._nodes[SIMULATOR].grant)
        self._due += self._time - before

    def _has_run(self, name: str) -> bool:
        """Runs a node until what was due is done; returns whether anything was."""
        executor, node = self._executors[name], self._nodes[name]
        return bool(self._run(name, lambda: run_all_due(executor, (node,))))

    def _run(self, name: str, act: Callable[[], Any]) -> Any:
        self._watch.begin(name)
        try:
            return act()
        except (Hangs, Exception) as error:
            died = self._died(name, error)
        finally:
            self._watch.name = ""
        self._drop(name)
        raise died

    def _drop(self, name: str) -> None:
        """Ends a node; time stands still without a simulator."""
        self._executors.pop(name).shutdown()
        self._nodes.pop(name).destroy_node()
        self.time_runs = self.time_runs and SIMULATOR in self._nodes
