"""bringup's graph kept up while its nodes are frozen, killed and lied to, and the robot driven to and fro in a hall."""

import io
import math
import os
import signal
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from collplan_ros.bringup.driving import wait_until_ready
from collplan_ros.bringup.ending import GraphError
from collplan_ros.bringup.graph import Graph
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import prepare
from collplan_ros.bringup.progress import Progress
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.messages.states import FREE
from collplan_ros.node_kit.diagnostics import ERROR
from faults.runner import Act, Bench, BenchError
from faults.streams import AT_REST, Streams

HALL = "{bounds: [-3.0, -1.6, 13.0, 1.6], walled: true, start: [0.0, 0.0], goal: [12.0, 0.0]}"
FULL, FULL_STRATEGY = 1.15, "avoid"
"""From here on the robot is at full speed [m/s], by this strategy; by the one as shipped it drives at 0.9 m/s."""
WAIT, PATIENCE, START = 2.0, 20.0, 30.0
"""Longest wait for rest and what should be there at once, for the robot to drive, for a node started again [s]."""
AGAIN = 0.8
"""Time after which a goal is given once more where the robot does not drive [s]."""


class LiveGraph(Graph, Bench):
    """A bench: a graph whose nodes may die."""

    # where the robot is driven to and fro [m]
    ends = np.array([0.0, 0.0]), np.array([12.0, 0.0])
    # speed from which on it is fast enough for a fault [m/s], and the strategy it drives by
    fast, strategy = 0.8, "harness"
    # of what counts as sent, and of the true motion
    topics = "cmd_vel", "ground_truth/odom"

    def __init__(self, robot: str) -> None:
        """`robot` is one of bringup's."""
        self._temporary = tempfile.TemporaryDirectory(prefix="faults-", ignore_cleanup_errors=True)
        folder = Path(self._temporary.name)
        preparation = prepare(self._options(robot, folder))
        super().__init__(preparation, RunFolder(folder / "runs", preparation.settings), Progress(io.StringIO()))

    def _options(self, robot: str, folder: Path) -> Options:
        (folder / "hall.yaml").write_text(HALL, encoding="utf-8")
        return Options(robot=robot, world=str(folder / "hall.yaml"), processes=True)

    def __enter__(self) -> "LiveGraph":
        super().__enter__()
        try:
            self.streams = Streams(self.listener.node, *self.topics)  # what its nodes send
            wait_until_ready(self)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        self.thaw(*self.processes.pids)
        super().__exit__(*exception)
        self._temporary.cleanup()

    def _check_nodes(self) -> None:
        """No node has to live, and others may command."""

    def until(self, condition: Callable[[], object], patience: float) -> bool:
        """Steps until `condition()`, at most `patience` [s]; whether it holds."""
        deadline = self.now() + patience
        while not (holds := bool(condition())) and self.now() < deadline:
            self.step()
        return holds

    def pause(self, seconds: float) -> None:
        """Steps for so long [s]."""
        self.until(lambda: False, seconds)

    def rest(self) -> None:
        """Until the robot is at rest, at most WAIT."""
        self.until(lambda: self.streams.truth[-1].speed <= AT_REST, WAIT)

    # ---- the robot

    def drive(self) -> None:
        """Until the robot goes fast to the hall's farther end, else BenchError; a new goal ends whatever held it."""
        self.let("planner_node", planner__strategy=self.strategy)
        deadline, due, target = self.now() + PATIENCE, 0.0, None
        while not (target is not None and self._drives and self.room(target) > 3.0):
            if self.now() > deadline:
                raise BenchError(f"the robot does not drive: {self.described()}")
            if self.now() > due and self.streams.truth:
                if target is None or self.streams.truth[-1].speed <= AT_REST:
                    target = self.farther_end()
                    with suppress(GraphError):
                        self.give_goal(target)
                due = self.now() + AGAIN
            self.step()

    @property
    def _drives(self) -> bool:
        streams = self.streams
        commanded = bool(streams.commands) and streams.commands[-1].moves
        return commanded and self.state == FREE and streams.truth[-1].speed >= self.fast

    def farther_end(self) -> np.ndarray:
        """The end of the hall (2,) that is farther away [m]."""
        return max(self.ends, key=self.room)

    def room(self, target: np.ndarray) -> float:
        """How far the robot is from there [m]."""
        here = self.streams.truth[-1]
        return math.hypot(here.x - target[0], here.y - target[1])

    def healthy(self, node: str) -> bool:
        """Whether a node's newest report is no error."""
        return node in self.streams.health and self.streams.health[node][1].level != ERROR

    @property
    def state(self) -> str:
        """The robot's own word of itself: free, held or stopped."""
        return str(self.streams.states[-1].what) if self.streams.states else ""

    def why_not(self, state: str) -> str:
        """Waits for the robot's word that it is in this state; that it is not, in words, or empty."""
        return "" if self.until(lambda: self.state == state, WAIT) else f"it is {self.state}, expected {state}"

    def value(self, node: str, name: str) -> str:
        """A value by its name of a node's newest report; empty where there is none."""
        return next((item.value for item in self.streams.health[node][1].values if item.key == name), "")

    def described(self) -> str:
        """What every node says."""
        said = (f"{name}: {status.message}" for name, (_, status) in sorted(self.streams.health.items()))
        return "; ".join([self.state, *said])

    # ---- what is done to it; what returns a time tells when it was done [s, steady clock]

    def trigger(self, service: str) -> bool:
        """Whether a service of type Trigger says yes."""
        return bool(self.call(Trigger, service, Trigger.Request()).success)

    def let(self, node: str, **values: object) -> float:
        """Sets parameters of a node, their group told by two underscores, emulator__faults; BenchError if refused."""
        begun = self.now()
        given = [Parameter(k.replace("__", "."), value=v).to_parameter_msg() for k, v in values.items()]
        answer = self.call(SetParameters, f"{node}/set_parameters", SetParameters.Request(parameters=given))
        refused = [result.reason for result in answer.results if not result.successful]
        if refused:
            raise BenchError(f"{node}: {refused}")
        return begun

    def freeze(self, *nodes: str) -> float:
        """Stops the nodes' processes."""
        return self._signalled(nodes, signal.SIGSTOP)

    def thaw(self, *nodes: str) -> float:
        """Lets frozen processes go on."""
        return self._signalled(nodes, signal.SIGCONT)

    def kill(self, *nodes: str) -> float:
        """Kills the nodes' processes."""
        return self._signalled(nodes, signal.SIGKILL)

    def restart(self, node: str) -> float:
        """Starts a node again that was killed, and waits until it is ready; BenchError if it does not report."""
        self.processes.kill(node)
        begun = self.now()
        self.start(node)
        if not self.until(lambda: self.streams.health[node][0] > begun, START):
            raise BenchError(f"{node} did not start again: {self._logs.last_lines(node)}")
        return self.streams.health[node][0]

    def _signalled(self, nodes: tuple[str, ...], number: int) -> float:
        begun = self.now()
        for node in filter(self.processes.runs, nodes):
            os.kill(self.processes.pids[node], number)
        return begun


def at_full_speed(act: Act) -> Act:
    """Does it once the robot goes as fast as it may; raises BenchError where it does not."""

    def acting(graph: LiveGraph) -> Any:
        graph.let("planner_node", planner__strategy=FULL_STRATEGY)
        if not graph.until(lambda: graph.streams.truth[-1].speed >= FULL, WAIT):
            raise BenchError(f"the robot does not reach {FULL} m/s: {graph.described()}")
        return act(graph)

    return acting
