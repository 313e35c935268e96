"""The nodes of a simulated robot in this process: simulated time passes pose by pose, and waits until they are done.

Within a process DDS delivers in `publish`, so nothing is under way once no node has anything left to do. Equal seeds
then give equal runs, however busy the machine is.
"""

import time
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from pkgutil import resolve_name
from typing import Any

from rclpy.executors import Executor
from rclpy.node import Node

from collplan_ros.bringup.failures import NodeDied
from collplan_ros.bringup.hang_watch import Hangs, HangWatch
from collplan_ros.bringup.robots import SIMULATOR
from collplan_ros.node_kit.events_executor import events_executor, run_all_due

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
CATCH_UP = 0.25
"""Time behind real time that is made up for [s]; more is given up."""


class SteppedNodes:
    """Nodes in this process, each with an executor of its own, run one after the other in the calling thread.

    Attributes:
        time_runs: whether simulated time passes in each step.
    """

    def __init__(
        self,
        own: Node,
        own_executor: Executor,
        watch: HangWatch,
        died: Callable[[str, BaseException], NodeDied],
        in_real_time: bool,
    ) -> None:
        """Makes no node yet.

        Args:
            own: bringup's node, which is run in turn with the others.
            own_executor: its executor.
            watch: is told of each turn.
            died: makes the error for a node that has raised.
            in_real_time: whether simulated time is at most as fast as real time.
        """
        self.time_runs = False
        self._context = own.context
        self._nodes: dict[str, Any] = {own.get_name(): own}
        self._executors = {own.get_name(): own_executor}
        self._died = died
        self._watch = watch
        self._in_real_time = in_real_time
        self._due = self._time = 0.0

    def start(self, name: str, arguments: Sequence[str]) -> None:
        """Makes a node with its command-line arguments.

        Raises:
            NodeDied: it cannot be made.
        """
        try:
            node = resolve_name(CLASSES[name])(context=self._context, cli_args=list(arguments))
        except Exception as error:
            raise self._died(name, error) from None
        executor = events_executor(self._context)
        executor.add_node(node)
        self._nodes[name], self._executors[name] = node, executor

    def let_time_run(self) -> None:
        """Lets simulated time pass in each step from now on; until then it stands still."""
        self.time_runs, self._due = True, time.monotonic()

    def now(self) -> float:
        """The time for patience [s]: simulated time once that runs, since nodes may take as long as they need."""
        return self._time if self.time_runs else time.monotonic()

    def step(self) -> None:
        """Lets simulated time pass until a pose is there, and runs the nodes until none has anything left to do.

        Raises:
            NodeDied: a node has raised, or does not return.
        """
        if not self.time_runs:
            time.sleep(STANDING_PERIOD)
        else:
            self._grant()
        self.settle()

    def settle(self) -> None:
        """Runs the nodes until none has anything left to do.

        Raises:
            NodeDied: a node has raised, or does not return.
        """
        while sum(map(self._has_run, tuple(self._executors))):
            pass

    def stop(self, names: Collection[str]) -> None:
        """Stops nodes as the end of their process would; what one raises then is in its log alone."""
        for name in [name for name in self._nodes if name in names]:
            node, executor = self._nodes[name], self._executors[name]
            with suppress(NodeDied):
                self._run(name, getattr(node, "stop", lambda: None))
            self._nodes.pop(name, None)
            self._executors.pop(name, None)
            executor.shutdown()
            node.destroy_node()
            self.time_runs = self.time_runs and name != SIMULATOR

    def _grant(self) -> None:
        before = self._time
        if self._in_real_time:
            ahead = self._due - time.monotonic()
            time.sleep(max(ahead, 0.0))
            self._due += max(-ahead - CATCH_UP, 0.0)

        def grant() -> None:
            self._time = self._nodes[SIMULATOR].grant()

        self._run(SIMULATOR, grant)
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
            # it takes no part in what follows
            self._nodes.pop(name, None)
            self._executors.pop(name, None)
            self.time_runs = self.time_runs and SIMULATOR in self._nodes
            raise self._died(name, error) from None
        finally:
            self._watch.end()
