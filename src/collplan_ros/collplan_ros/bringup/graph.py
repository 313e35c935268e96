"""What is started: the nodes, in processes or in this one, beside bringup's own; waited for, given goals, stopped."""

import gc
import math
import os
import signal
import threading
import time
import traceback
from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack, closing, contextmanager
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import Log
from rclpy.client import Client
from std_srvs.srv import Trigger

from collplan_core.parameters.spec import ParameterError
from collplan_ros.bringup import watching
from collplan_ros.bringup.ending import GraphError, Interrupted, NodeDied, NodeRefused, StartError
from collplan_ros.bringup.one_process import CLASSES, Hangs, SteppedNodes
from collplan_ros.bringup.options import COMMANDER, PLANNER, VIEWER
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.processes import ERROR, WARN, NodeLogs, Processes
from collplan_ros.bringup.progress import Progress
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.bringup.watching import Complaints, Listener
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.qos import EVENT
from collplan_ros.node_kit.reachability import environment_set
from collplan_ros.node_kit.stop_signal import StopSignal
from collplan_ros.run.run_log import PoseRow

Words = Callable[[], str]
NOTICE_TIME = 5.0  # time after which it is said what is waited for [s]
COMPILES = "compiles the planner, once: that takes minutes (or this machine is busy)"
GOAL_PERIOD = 1.0  # period at which a goal without answer is published again [s]
COMMANDERS_PERIOD = 0.1  # period at which the publishers of commands are looked at [s]
LISTENING_TIME = 0.5  # time within which other nodes in the domain are discovered [s]
REPORT_PERIOD = 1.1  # real time within which each node reports [s]


class Graph:
    """A context manager: entering starts every node, leaving stops them; it has its listener once entered.

    The nodes are killed when the thread that entered ends, whatever the reason. Entering raises StartError where a node
    of the same name is in the domain already; every method that waits NodeDied, GraphError, Interrupted, RecordError.
    """

    def __init__(self, preparation: Preparation, folder: RunFolder, progress: Progress) -> None:
        """Prepares the graph, whose files go to `folder`; no process is started before entering."""
        self.preparation, self.progress = preparation, progress
        self.folder, self._logs = folder, NodeLogs(folder.logs)
        self.processes = Processes(self._logs)
        self.stepped: SteppedNodes | None = None
        """The nodes in this process; None where there are none."""
        self.is_ready = False
        """Whether every node works; from then on the page may be missing, and no other node may command."""
        self._stop_signal, self._stack = StopSignal(), ExitStack()
        self._commanders_due = 0.0
        self._first_said: dict[str, str] = {}
        self._clients: dict[str, Client] = {}

    def __enter__(self) -> "Graph":
        preparation, options = self.preparation, self.preparation.options
        with ExitStack() as stack:
            stack.enter_context(environment_set(preparation.environment))
            if not os.environ.get("ROS_LOG_DIR"):  # the folder of ROS's own logs would need a home
                stack.enter_context(environment_set({"ROS_LOG_DIR": str(self.folder.logs)}))
            stack.enter_context(self._stop_signal.listening())
            self.listener = stack.enter_context(closing(Listener(preparation, self.folder)))
            self.recorder, node = self.listener.recorder, self.listener.node
            self.complaints = Complaints(preparation, self.listener)
            self.listener.topics.listen("/rosout", self._say_logged)
            self.goals = node.create_publisher(PoseStamped, "goal_pose", EVENT)
            self._cancel = node.create_client(Trigger, "cancel")
            if not preparation.robot.simulated:
                self._refuse_running_nodes()
            here = [name for name in CLASSES if name in preparation.programs] if options.in_one_process else []
            if options.in_one_process:
                in_real_time = options.real_time or options.view
                self.stepped = SteppedNodes(node, self.listener.executor, self._died, in_real_time)
                stack.enter_context(self.stepped.watching())
                self.listener.now, self.listener.spin = self.stepped.now, self.stepped.step
                self.listener.topics.listen("/rosout", lambda message, _: self._logs.take(message))
            stack.callback(self._stop_nodes)
            for name in preparation.programs.keys() - here:
                self.start(name)
            if self.stepped is not None:
                self._make(here, self.stepped)
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *exception: object) -> None:
        self._stack.close()

    def start(self, name: str) -> None:
        """Starts the process of a node."""
        arguments = self.preparation.arguments(name, self.folder)
        self.processes.start(name, [self.preparation.programs[name], *arguments])

    def _make(self, names: Collection[str], stepped: SteppedNodes) -> None:
        """Makes nodes of this process; they may have to compile first."""
        try:
            with self.notice(lambda: COMPILES), self._stop_signal.at_once():
                for name in names:
                    stepped.start(name, self.preparation.arguments(name, self.folder))
        except KeyboardInterrupt:
            raise Interrupted(self._stop_signal.number or signal.SIGINT) from None
        gc.freeze()  # to look through what was compiled and imported for garbage takes a tenth of a second

    @contextmanager
    def notice(self, words: Words) -> Iterator[None]:
        """Says what is waited for, where it is not left within NOTICE_TIME."""
        notice = threading.Timer(NOTICE_TIME, lambda: self.progress.say(words()))
        notice.daemon = True
        notice.start()
        try:
            yield
        finally:
            notice.cancel()

    @property
    def pose(self) -> PoseRow:
        """The newest pose; GraphError where none has come while messages were waited for, for INPUT_PATIENCE."""
        if self.recorder.newest is None or self.listener.silence > watching.INPUT_PATIENCE:
            raise GraphError(self.complaints.no_pose() + self.complaints.frozen)
        return self.recorder.newest

    def step(self) -> None:
        """Takes arriving messages, for a moment; raises where a signal came, a node has ended or another commands."""
        if self._stop_signal.number is not None:
            raise Interrupted(self._stop_signal.number)
        self._check_nodes()
        self.listener.take()

    def wait(self, condition: Callable[[], bool], patience: float = math.inf, complaint: Words = str) -> None:
        """Steps until `condition()`; after `patience` [s] it raises GraphError with `complaint()`."""
        deadline = self.now() + patience
        while not condition():
            if self.now() > deadline:
                self._hear_reports()
                raise GraphError(complaint() + self.complaints.frozen)
            self.step()

    def call(self, kind: type, service: str, request: Any) -> Any:
        """The response of a service; GraphError where none of this name answers for INPUT_PATIENCE."""
        if service not in self._clients:
            self._clients[service] = self.listener.node.create_client(kind, service)
        client = self._clients[service]
        self.wait(client.service_is_ready, watching.INPUT_PATIENCE, lambda: f"{service}: no such service")
        answer = client.call_async(request)
        self.wait(answer.done, watching.INPUT_PATIENCE, lambda: f"{service}: no answer")
        return answer.result()

    def now(self) -> float:
        """The time for patience [s]."""
        return self.listener.now()

    def give_goal(self, goal: np.ndarray) -> None:
        """Publishes a goal (2,) [m], each GOAL_PERIOD until the planner answers."""
        self.recorder.ask(goal)
        due = -math.inf

        def answered() -> bool:
            nonlocal due
            stamp = self.pose.stamp
            if self.now() >= due:
                self.goals.publish(goal_to_message(goal, self.preparation.settings.frames.map, stamp))
                due = self.now() + GOAL_PERIOD
            return self.recorder.goal is not None

        self.wait(answered, watching.INPUT_PATIENCE, self.complaints.no_planner)

    def cancel_goal(self) -> None:
        """Asks for the end of the goal; nobody waits for the answer."""
        if self._cancel.service_is_ready():
            self._cancel.call_async(Trigger.Request())

    def _hear_reports(self) -> None:
        """Waits for the nodes' reports, which simulated time may have left behind."""
        end = time.monotonic() + REPORT_PERIOD * (self.stepped is not None)
        while time.monotonic() < end:
            self.listener.take()

    def _check_nodes(self) -> None:
        """Checks that all nodes live, and once they are ready that no other one commands the robot."""
        self.processes.check(self.progress.say, {VIEWER: "its page"} if self.is_ready else {})
        if not self.is_ready or time.monotonic() < self._commanders_due:
            return
        self._commanders_due = time.monotonic() + COMMANDERS_PERIOD
        if others := self.complaints.other_commanders():
            raise GraphError(others)

    def _say_logged(self, message: Log, _: float) -> None:
        """Prints a node's error when it happens, and why a robot that is not simulated stands."""
        robot, (space, _, name) = self.preparation.robot, message.name.rpartition(".")
        if name not in self.preparation.programs or f"/{space.replace('.', '/')}" != self.preparation.namespace:
            return
        stands = not robot.simulated and name in (robot.nodes[0], COMMANDER)
        # what two nodes say alike of a topic that both take is printed once
        if message.level >= (WARN if stands else ERROR) and self._first_said.setdefault(message.msg, name) == name:
            self.progress.say(f"{name}: {message.msg}")

    def _refuse_running_nodes(self) -> None:
        end = time.monotonic() + LISTENING_TIME
        while time.monotonic() < end:
            self.step()
            if others := self.complaints.not_alone(own=0):
                raise StartError(others)

    def _stop_nodes(self) -> None:
        """The commander first: the robot must receive its last zero; then the planner, while its sources still run."""
        try:
            self._stop([COMMANDER])
            self.listener.record_to_the_end()
            self._stop([PLANNER])
            self.listener.topics.take_all()
        finally:
            for name in self.processes.stop_all(last=self.preparation.robot.nodes[1:]):
                self.progress.say(f"{name} did not stop on request and was killed")
            self._stop(self.preparation.programs)
            self.listener.topics.take_all()

    def _stop(self, names: Collection[str]) -> None:
        self.processes.stop(names)
        if self.stepped is not None:
            self.stepped.stop(names)

    def _died(self, name: str, error: BaseException) -> NodeDied:
        """Writes what a node of this process has raised to its log, and prints the last lines of that."""
        self._logs.append(name, "".join(traceback.format_exception(error)))
        self.progress.say(self._logs.last_lines(name))
        said = f"ended by {type(error).__name__}: {' '.join(str(error).split())}"
        refused = isinstance(error, ParameterError)
        return (NodeRefused if refused else NodeDied)(f"{name} {'hangs' if isinstance(error, Hangs) else said}")
