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
from action_msgs.msg import GoalStatus
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from collplan_ros.bringup.driving import wait_until_ready
from collplan_ros.bringup.failures import GraphError
from collplan_ros.bringup.graph import Graph
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import prepare
from collplan_ros.bringup.progress import Progress
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.messages.states import FREE
from collplan_ros.node_kit.diagnostics import ERROR
from faults.bench import Bench, BenchError
from faults.fault import Act
from faults.streams import AT_REST, Streams

HALL = """
bounds: [-3.0, -1.6, 13.0, 1.6]
walled: true
start: [0.0, 0.0]
goal: [12.0, 0.0]
"""
ENDS = np.array([0.0, 0.0]), np.array([12.0, 0.0])
"""Where the robot is driven to and fro [m]."""
FENCE_GAP = (-1.4, -0.8), -1.0
"""Where the fence leaves out a piece of the hall, behind the start: from and to x, and from y on [m]."""
FENCE = (-3.0, -1.6, 13.0, -1.6, 13.0, 1.6, -0.8, 1.6, -0.8, -1.0, -1.4, -1.0, -1.4, 1.6, -3.0, 1.6)
FAST, FULL = 0.8, 1.15
"""The robot is fast enough for a fault from here on, and at full speed [m/s]."""
SLOW_STRATEGY, FULL_STRATEGY = "harness", "avoid"
"""The one as shipped drives at 0.9 m/s, the other one at robot.max_speed."""
REST = 2.0
"""Longest wait for the robot to come to rest [s]."""
PATIENCE = 20.0
"""Longest wait for the robot to drive [s]."""
AGAIN = 0.8
"""Time after which a goal is given once more where the robot does not drive [s]."""
ANSWER = 3.0
"""Longest wait for somebody who listens [s]."""
START = 30.0
"""Longest wait for a node that has been started again [s]."""


UNDER_WAY = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING)


class LiveGraph(Graph, Bench):
    """A bench: a graph whose nodes may die.

    Attributes:
        streams: what its nodes send.
        ends: where the robot is driven to and fro [m].
        fast: speed from which on it is fast enough for a fault [m/s].
        strategy: by which it drives.
    """

    ends, fast, strategy = ENDS, FAST, SLOW_STRATEGY

    def __init__(self, robot: str) -> None:
        """`robot` is one of bringup's."""
        self._temporary = tempfile.TemporaryDirectory(prefix="faults-", ignore_cleanup_errors=True)
        folder = Path(self._temporary.name)
        preparation = prepare(self._options(robot, folder))
        run_folder = RunFolder(folder / "runs", preparation.settings)
        super().__init__(preparation, run_folder, Progress(io.StringIO()))
        self._repeated: Callable[[], object] | None = None
        self._period = self._due = 0.0

    def _options(self, robot: str, folder: Path) -> Options:
        (folder / "hall.yaml").write_text(HALL, encoding="utf-8")
        file = folder / "parameters.yaml"
        fenced = f"/**:\n  ros__parameters:\n    limits: {{fence: {list(FENCE)}}}\n"
        file.write_text(fenced, encoding="utf-8")
        return Options(robot=robot, world=str(folder / "hall.yaml"), params=file, processes=True)

    def _streams(self) -> Streams:
        return Streams(self.listener.node)

    def __enter__(self) -> "LiveGraph":
        super().__enter__()
        try:
            self.streams = self._streams()
            wait_until_ready(self)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        for node in self.processes.pids:
            self.thaw(node)
        super().__exit__(*exception)
        self._temporary.cleanup()

    def _check_nodes(self) -> None:
        """Repeats what is to be: no node has to live, and others may command."""
        if self._repeated is not None and self.now() >= self._due:
            self._due = self.now() + self._period
            self._repeated()

    def repeat(self, period: float, act: Callable[[], object] | None) -> None:
        """Calls `act` every `period` [s] from now on, while stepping; None ends it."""
        self._period, self._due, self._repeated = period, self.now(), act

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
        """Until the robot is at rest, at most REST."""
        self.until(lambda: not self.moves, REST)

    # ---- the robot

    def drive(self) -> None:
        """Until the robot goes fast to the farther end of the hall; a new goal lets it move whatever has held it.

        Raises:
            BenchError: it does not.
        """
        self.let("planner_node", planner__strategy=self.strategy)
        deadline, due, target = self.now() + PATIENCE, 0.0, None
        while not (target is not None and self.drives and self.room(target) > 3.0):
            if self.now() > deadline:
                raise BenchError(f"the robot does not drive: {self.described()}")
            if self.now() > due and self.streams.truth:
                if target is None or not self.moves:
                    target = self.farther_end()
                    with suppress(GraphError):
                        self.give_goal(target)
                due = self.now() + AGAIN
            self.step()

    def farther_end(self) -> np.ndarray:
        """The end of the hall (2,) that is farther away [m]."""
        return max(self.ends, key=self.room)

    @property
    def goal_goes_on(self) -> bool:
        """Whether the newest goal has not ended."""
        return bool(self.streams.goals) and self.streams.goals[-1].what in UNDER_WAY

    def healthy(self, node: str) -> bool:
        """Whether a node's newest report is no error."""
        return node in self.streams.health and self.streams.health[node][1].level != ERROR

    def room(self, target: np.ndarray) -> float:
        """How far the robot is from there [m]."""
        here = self.streams.truth[-1]
        return math.hypot(here.x - target[0], here.y - target[1])

    @property
    def moves(self) -> bool:
        """Whether it moves now."""
        return self.streams.truth[-1].speed > AT_REST

    @property
    def drives(self) -> bool:
        """Whether it goes fast, as commanded."""
        streams = self.streams
        commanded = bool(streams.commands) and streams.commands[-1].moves
        return commanded and self.state == FREE and streams.truth[-1].speed >= self.fast

    @property
    def state(self) -> str:
        """The robot's own word of itself: free, held or stopped."""
        return str(self.streams.states[-1].what) if self.streams.states else ""

    def value(self, node: str, name: str) -> str:
        """A value by its name of a node's newest report; empty where there is none."""
        return next((item.value for item in self.streams.health[node][1].values if item.key == name), "")

    def described(self) -> str:
        """What every node says."""
        said = "; ".join(f"{name}: {status.message}" for name, (_, status) in sorted(self.streams.health.items()))
        speed = self.streams.truth[-1].speed if self.streams.truth else math.nan
        return f"{self.state}, {speed:.2f} m/s; {said}"

    # ---- what is done to it

    def trigger(self, service: str) -> bool:
        """Whether a service of type Trigger says yes."""
        return bool(self.call(Trigger, service, Trigger.Request()).success)

    def let(self, node: str, **values: object) -> None:
        """Sets parameters of a node; their group is told from the name by two underscores: emulator__unplugged.

        Raises:
            BenchError: they are refused.
        """
        given = [Parameter(k.replace("__", "."), value=v).to_parameter_msg() for k, v in values.items()]
        answer = self.call(SetParameters, f"{node}/set_parameters", SetParameters.Request(parameters=given))
        refused = [result.reason for result in answer.results if not result.successful]
        if refused:
            raise BenchError(f"{node}: {refused}")

    def freeze(self, node: str) -> float:
        """Stops a node's process; returns when [s, steady clock]."""
        return self._signalled(node, signal.SIGSTOP)

    def thaw(self, node: str) -> float:
        """Lets a frozen process go on; returns when [s, steady clock]."""
        return self._signalled(node, signal.SIGCONT)

    def kill(self, node: str) -> float:
        """Kills a node's process; returns when [s, steady clock]."""
        return self._signalled(node, signal.SIGKILL)

    def restart(self, node: str) -> float:
        """Starts a node again that was killed, and waits until it is ready; returns when it was [s, steady clock].

        Raises:
            BenchError: it does not report.
        """
        self.processes.kill(node)
        begun = self.now()
        self.processes.start(node, self.preparation.command(node, self._folder))
        if not self.until(lambda: self.streams.health[node][0] > begun, START):
            raise BenchError(f"{node} did not start again: {self.processes.last_lines(node)}")
        return self.streams.health[node][0]

    def _signalled(self, node: str, number: int) -> float:
        begun = self.now()
        if self.processes.runs(node):
            os.kill(self.processes.pids[node], number)
        return begun


def at_full_speed(act: Act) -> Act:
    """Does it once the robot goes as fast as it may.

    Raises:
        BenchError: it does not.
    """

    def acting(graph: LiveGraph) -> Any:
        graph.let("planner_node", planner__strategy=FULL_STRATEGY)
        if not graph.until(lambda: graph.streams.truth[-1].speed >= FULL, REST):
            raise BenchError(f"the robot does not reach {FULL} m/s: {graph.described()}")
        return act(graph)

    return acting
