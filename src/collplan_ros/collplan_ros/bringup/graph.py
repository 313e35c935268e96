"""The running graph: its nodes, in processes or in this one, and bringup's own, which listens and gives the goal."""

import gc
import os
import signal
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Collection
from contextlib import ExitStack, closing
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import Log
from rclpy.client import Client
from rclpy.node import Node
from std_srvs.srv import Trigger

from collplan_core.parameters.spec import ParameterError
from collplan_ros.bringup import complaints
from collplan_ros.bringup.complaints import COMMANDS, Complaints, other_commanders, seen_more_than
from collplan_ros.bringup.failures import GraphError, Interrupted, NodeDied, NodeRefused, StartError
from collplan_ros.bringup.listener import NAME, Listener
from collplan_ros.bringup.network import environment_set, graph_environment
from collplan_ros.bringup.options import COMMANDER, PLANNER, VIEWER
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.processes import ERROR, WARN, NodeLogs, Processes
from collplan_ros.bringup.progress import Progress, in_words
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.bringup.stepped_nodes import CLASSES, Hangs, HangWatch, SteppedNodes
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.qos import EVENT
from collplan_ros.node_kit.stop_signal import StopSignal
from collplan_ros.run.run_log import PoseRow

NOTICE_TIME = 5.0
"""Time after which it is said what is waited for [s]."""
GOAL_PERIOD = 1.0
"""Period at which a goal without answer is published again [s]."""


class Goals:
    """Publisher of goals to the planner, which answers by the status of the goal."""

    def __init__(self, node: Node, frame: str, now: Callable[[], float]) -> None:
        """Publishes through `node` goals in `frame`; `now` is the time for patience [s]."""
        self._now = now
        self._frame = frame
        self._due = 0.0
        self._publisher = node.create_publisher(PoseStamped, "goal_pose", EVENT)
        self._cancel = node.create_client(Trigger, "cancel")

    @property
    def are_heard(self) -> bool:
        """True where a node subscribes to goals."""
        return bool(self._publisher.get_subscription_count() > 0)

    def give(self, goal: np.ndarray, stamp: float) -> None:
        """Publishes a goal (2,) [m] with a stamp [s]."""
        self._publisher.publish(goal_to_message(goal, self._frame, stamp))
        self._due = self._now() + GOAL_PERIOD

    def repeat(self, goal: np.ndarray, stamp: float) -> None:
        """Publishes it again, once GOAL_PERIOD is over."""
        if self._now() >= self._due:
            self.give(goal, stamp)

    def cancel(self) -> None:
        """Asks for the end of the goal."""
        if self._cancel.service_is_ready():
            self._cancel.call_async(Trigger.Request())


COMMANDERS_PERIOD = 0.1
"""Period at which the publishers of commands are looked at [s]."""
LISTENING_TIME = 0.5
"""Time within which other nodes in the domain are discovered [s]."""
REPORT_PERIOD = 1.1
"""Real time within which each node reports [s]."""
LATE = 1.0
"""Age at which a pose no longer shows the robot's present state [s]."""
CATCH_UP_PATIENCE = 5.0
"""Longest wait for poses that are not late, once those taken are [s]."""


class Graph:
    """A context manager: entering starts every node, leaving stops them.

    The nodes are killed when the thread that entered ends, whatever the reason.

    Attributes:
        preparation: the run to start.
        processes: the nodes that have a process each.
        stepped: the nodes in this process; None where there are none.
        progress: output for the user.
        is_ready: whether every node works; from then on the page may be missing, and no other node may command.
        listener, recorder, goals, complaints: once entered.

    Raises:
        StartError: on entering, when a node of the same name is in the domain already.
        NodeDied, GraphError, Interrupted, RecordError: from every method that waits.
    """

    def __init__(self, preparation: Preparation, folder: RunFolder, progress: Progress) -> None:
        """Prepares the graph, whose files go to `folder`; no process is started before entering."""
        self.preparation = preparation
        self._logs = NodeLogs(folder.logs)
        self.processes = Processes(self._logs)
        self.stepped: SteppedNodes | None = None
        self.progress = progress
        self.is_ready = False
        self._folder = folder
        self._stop_signal = StopSignal()
        self._stack = ExitStack()
        self._commanders_due = 0.0
        self._first_said: dict[str, str] = {}
        self._clients: dict[str, Client] = {}

    def __enter__(self) -> "Graph":
        preparation = self.preparation
        with ExitStack() as stack:
            alone = preparation.robot.simulated and preparation.network == "local"
            stack.enter_context(environment_set(graph_environment(preparation.network, os.environ, alone)))
            if not os.environ.get("ROS_LOG_DIR"):  # the folder of ROS's own logs would need a home
                stack.enter_context(environment_set({"ROS_LOG_DIR": str(self._folder.logs)}))
            stack.enter_context(self._stop_signal.listening())
            self.listener = stack.enter_context(closing(Listener(preparation, self._folder)))
            self.recorder, node = self.listener.recorder, self.listener.node
            self.complaints = Complaints(preparation, self.recorder, node)
            self.listener.listen_to_logs(self._say_logged)
            self.goals = Goals(node, preparation.settings.frames.map, self.now)
            if not preparation.robot.simulated:
                self._refuse_running_nodes()
            watch = HangWatch()
            if preparation.in_one_process:
                stack.enter_context(watch.watching())
            stack.callback(self._stop_nodes)
            here = [name for name in CLASSES if name in preparation.programs] if preparation.in_one_process else []
            for name in preparation.programs.keys() - here:
                self.processes.start(name, preparation.command(name, self._folder))
            if here:
                self.stepped = SteppedNodes(*self.listener.spun, watch, self._died, preparation.in_real_time)
                self.listener.spin_with(self.stepped, self._logs)
                self._make(here, self.stepped)
                gc.freeze()  # to look through what was compiled and imported for garbage takes a tenth of a second
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *exception: object) -> None:
        self._stack.close()

    def _make(self, names: Collection[str], stepped: SteppedNodes) -> None:
        """Makes nodes of this process; they may have to compile first."""
        said = "compiles the planner, once: that takes minutes (or this machine is busy)"
        notice = threading.Timer(NOTICE_TIME, self.progress.say, [said])
        notice.daemon = True
        notice.start()
        try:
            with self._stop_signal.at_once():
                for name in names:
                    stepped.start(name, self.preparation.arguments(name, self._folder))
        except KeyboardInterrupt:
            raise Interrupted(self._stop_signal.number or signal.SIGINT) from None
        finally:
            notice.cancel()

    @property
    def pose(self) -> PoseRow:
        """The newest pose.

        Raises:
            GraphError: there is none, or none has come while messages were waited for, for INPUT_PATIENCE.
        """
        if self.recorder.newest is None or self.listener.silence > complaints.INPUT_PATIENCE:
            raise GraphError(self.complaints.no_pose() + self.complaints.frozen)
        return self.recorder.newest

    def step(self) -> None:
        """Takes arriving messages, for a moment.

        Raises:
            Interrupted: a signal came.
            NodeDied: a node has ended.
            GraphError: another node commands the robot too.
            RecordError: the recording cannot be written.
        """
        if self._stop_signal.number is not None:
            raise Interrupted(self._stop_signal.number)
        self._check_nodes()
        self.listener.take()

    def wait(self, condition: Callable[[], bool], patience: float, complaint: Callable[[], str]) -> None:
        """Steps until `condition()`.

        Raises:
            GraphError: with `complaint()`, after `patience` [s].
        """
        deadline = self.now() + patience
        while not condition():
            if self.now() > deadline:
                self._hear_reports()
                raise GraphError(complaint() + self.complaints.frozen)
            self.step()

    def call(self, kind: type, service: str, request: Any) -> Any:
        """The response of a service.

        Raises:
            GraphError: there is none of this name, or it does not answer, for INPUT_PATIENCE.
        """
        if service not in self._clients:
            self._clients[service] = self.listener.node.create_client(kind, service)
        client = self._clients[service]
        self.wait(client.service_is_ready, complaints.INPUT_PATIENCE, lambda: f"{service}: no such service")
        answer = client.call_async(request)
        self.wait(answer.done, complaints.INPUT_PATIENCE, lambda: f"{service}: no answer")
        return answer.result()

    def now(self) -> float:
        """The time for patience [s]."""
        return self.listener.now()

    def let_time_run(self) -> None:
        """Lets simulated time pass from now on, where it waits for the nodes; before, it stands still."""
        if self.stepped is not None:
            self.stepped.let_time_run()

    def catch_up(self) -> None:
        """Steps until the newest pose is not LATE.

        Raises:
            GraphError: poses stay late for CATCH_UP_PATIENCE.
        """
        self.wait(lambda: self.recorder.lateness <= LATE, CATCH_UP_PATIENCE, self.complaints.too_slow)

    def give_goal(self, goal: np.ndarray) -> None:
        """Publishes a goal (2,) [m] and waits for the planner's answer."""
        self.recorder.ask(goal)
        self.goals.give(goal, self.pose.stamp)

        def answered() -> bool:
            self.goals.repeat(goal, self.pose.stamp)
            return self.recorder.goal is not None

        self.wait(answered, complaints.INPUT_PATIENCE, self.complaints.no_planner)

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
        others = other_commanders(self.listener.node, COMMANDER)
        if others:
            topic = self.complaints.name(COMMANDS)
            raise GraphError(f"{topic} is published by {in_words(others)} beside {COMMANDER}; end all but {COMMANDER}")

    def _say_logged(self, message: Log) -> None:
        """Prints a node's error when it happens, and why a robot that is not simulated stands."""
        robot, (space, _, name) = self.preparation.robot, message.name.rpartition(".")
        if name not in self.preparation.programs or f"/{space.replace('.', '/')}" != self.preparation.namespace:
            return
        stands = not robot.simulated and name in (robot.nodes[0], COMMANDER)
        # what two nodes say alike of a topic that both take is printed once
        if message.level >= (WARN if stands else ERROR) and self._first_said.setdefault(message.msg, name) == name:
            self.progress.say(f"{name}: {message.msg}")

    def _refuse_running_nodes(self) -> None:
        alone = Counter({**dict.fromkeys(self.preparation.programs, 0), NAME: 1})
        end = time.monotonic() + LISTENING_TIME
        while time.monotonic() < end:
            self.step()
            others = seen_more_than(self.listener.node, alone)
            if others:
                raise StartError(self.complaints.not_alone(f"{in_words(others)} already"))

    def _stop_nodes(self) -> None:
        """The commander first: its last command is zero, and the robot must still run to receive it.

        The planner is next, while the sources of its scans and poses still run: messages on their way to the recording
        are lost with their sender.
        """
        try:
            self._stop([COMMANDER])
            self.listener.record_to_the_end()
            self._stop([PLANNER])
            self.listener.take_all()
        finally:
            for name in self.processes.stop_all(last=self.preparation.robot.nodes[1:]):
                self.progress.say(f"{name} did not stop on request and was killed")
            self._stop(self.preparation.programs)
            self.listener.take_all()

    def _stop(self, names: Collection[str]) -> None:
        self.processes.stop(names)
        if self.stepped is not None:
            self.stepped.stop(names)

    def _died(self, name: str, error: BaseException) -> NodeDied:
        """Writes what a node of this process has raised to its log, and prints the last lines of that."""
        self._logs.append(name, "".join(traceback.format_exception(error)))
        self.progress.say(self._logs.last_lines(name))
        how = (
            "hangs" if isinstance(error, Hangs) else f"ended by {type(error).__name__}: {' '.join(str(error).split())}"
        )
        return (NodeRefused if isinstance(error, ParameterError) else NodeDied)(f"{name} {how}")
