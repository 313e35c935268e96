"""The running graph: one process per node, and bringup's own node, which records and publishes the goal."""

import math
import os
import time
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import partial
from threading import Lock

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from collplan_core.parameters import Mocap
from collplan_ros.bringup.commanders import TOPIC, other_commanders
from collplan_ros.bringup.failures import GraphError, NodeDied, StartError
from collplan_ros.bringup.network import described, environment_set, graph_environment
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.processes import NodeProcess, stop, stop_all
from collplan_ros.bringup.progress import Progress
from collplan_ros.bringup.robots import LIDAR, VIEWER
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.bringup.signals import StopRequest
from collplan_ros.bringup.words import in_words
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.qos import EVENT
from collplan_ros.node_kit.clock import local_clock, seconds
from collplan_ros.node_kit.diagnostics import ERROR
from collplan_ros.node_kit.events_executor import events_executor
from collplan_ros.node_kit.node_names import full_name
from collplan_ros.run.description import describe_run
from collplan_ros.run.graph_topics import GraphTopics, PollingNode
from collplan_ros.run.recorder import Recorder
from collplan_ros.run.run_log import PoseRow
from collplan_ros.run.send_times import SendTimes
from collplan_ros.run.topics import recorded_topics
from collplan_ros.run.writer import RecordingFile

NAME = "bringup"
COMMANDER, PLANNER = "controller_node", "planner_node"
"""The only node that commands the robot is stopped first: its last command is zero, and the robot must still run to
receive it. planner_node is next, while those are still there whose scans and poses it takes: what is on its way to the
recording is lost with its sender."""
COMMANDERS_PERIOD = 0.1
"""Period at which the publishers of commands are looked at [s]."""
REST_SPEED = 0.03
"""Speed below which the robot counts as at rest [m/s]."""
ZERO_PATIENCE = 0.3
"""Longest wait for the zero of a controller that was stopped: without one the robot stands by itself by then [s]."""
REST_PATIENCE = 5.0
"""Longest wait for the robot to stop after a run [s]."""
WHOLE_PATIENCE = 10.0
"""Longest wait for what is still under way of a run's record [s]."""
SILENCE = 1.0
"""Time without poses after which none is waited for while the graph is stopped [s]."""
LISTENING_TIME = 0.5
"""Time within which other nodes in the domain are discovered [s]."""
SERIAL_ENDS = {"firmware_emulator": "emulator.link", "driver_node": "driver.port"}
"""Parameters that name the pseudo-terminal in the place of a serial device, by node."""
SIMULATED_TIME = ["-p", "use_sim_time:=true"]
LATE_COMMANDS = ("late", "expired")
"""Figures of a robot's report: commands too old when they came, and those that became so before the next one came."""
READY_PATIENCE = 300.0
"""Longest wait for the nodes to report; they may have to compile first [s]."""
NOTICE_TIME = 5.0
"""Time after which the nodes still waited for are printed [s]."""
LINK_PATIENCE = 3.0
"""Longest wait for the robot's link, once every node has reported [s]."""
INPUT_PATIENCE = 3.0
"""Longest wait for poses, scans and the answer to a goal, once every node is ready [s]."""
LATE = 1.0
"""Time after sending at which a pose no longer tells how the robot is now [s]."""
CATCH_UP_PATIENCE = 5.0
"""Longest wait for poses that are not late, once those taken are [s]."""
LONGEST_SILENCE = 2.5
"""Time without diagnostics after which a node counts as frozen [s]: each node sends them once a second."""
GOAL_PERIOD = 1.0
"""Period at which a goal without answer is published again [s]."""
TAKING_PERIOD = 0.01
"""Period at which what has come is taken [s]: to wait for each message costs a multiple of it."""
AT_ONCE = 4
"""Messages of the node's own subscriptions that are taken between two looks at its clock."""
LONGEST_STEP = 0.1
"""What a step counts at most as time without poses [s]: one that takes longer was stalled by the machine."""


def _nowhere(name: str, values: Mapping[str, str]) -> None:
    """Marks no place, where nothing is recorded."""


class Graph:
    """A context manager: entering starts every node, leaving stops them.

    The nodes are killed when the thread that entered ends, whatever the reason.

    Raises:
        StartError: on entering, when a node of the same name is in the domain already.
        NodeDied, GraphError, Interrupted, RecordError: from every method that waits.
    """

    def __init__(
        self,
        preparation: Preparation,
        folder: RunFolder,
        progress: Progress,
        recording: bool = True,
        commands: bool = False,
    ) -> None:
        """Prepares the graph; no process is started before entering.

        Args:
            preparation: what is started.
            folder: the run folder.
            progress: what is said while it runs.
            recording: whether every topic is recorded.
            commands: whether its node commands the robot itself, by the clock of the other nodes.
        """
        self._commands = commands
        self._preparation = preparation
        self._folder = folder
        self._progress = progress
        self._processes: list[NodeProcess] = []
        self._stop_request = StopRequest()
        self._stack = ExitStack()
        self._silence = 0.0
        self._robot_knows_planner = self._ready = False
        self.robot_waits = ""
        """Reason for which the robot stands, and how to release it; empty while it is free or has not reported yet."""
        self._is_recorded = recording
        self._recording: RecordingFile | None = None
        self._may_be_more = False
        self._spinning = Lock()
        self._commanders_due = math.inf

    def __enter__(self) -> "Graph":
        with ExitStack() as stack:
            stack.enter_context(environment_set(graph_environment(self._preparation.network, os.environ)))
            stack.enter_context(self._stop_request.listening())
            self._open_node(stack)
            self._refuse_running_nodes()
            stack.callback(self._stop_processes)
            for name, program in self._preparation.programs.items():
                command = [program, "--ros-args", *self._ros_arguments(name)]
                self._processes.append(NodeProcess(name, command, self._folder.logs / f"{name}.log"))
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *exception: object) -> None:
        self._stack.close()

    @property
    def pids(self) -> dict[str, int]:
        """Process id of each node by name."""
        return {process.name: process.pid for process in self._processes}

    @property
    def pose(self) -> PoseRow:
        """The newest pose.

        Raises:
            GraphError: there is none, or none has come while messages were waited for, for INPUT_PATIENCE.
        """
        if self.recorder.newest is None or self._silence > INPUT_PATIENCE:
            raise GraphError(self._no_pose() + self.frozen)
        return self.recorder.newest

    def step(self) -> None:
        """Takes what comes in TAKING_PERIOD, or at once what has come where that is much.

        Raises:
            Interrupted: a signal came.
            NodeDied: a node has ended.
            GraphError: another node commands the robot too.
            RecordError: the recording cannot be written.
        """
        self._stop_request.check()
        for process in list(self._processes):
            self._check(process)
        self._refuse_other_commanders()
        self._take_what_came()
        if self._recording is not None:
            self._recording.flush_when_due()

    def _check(self, process: NodeProcess) -> None:
        try:
            process.check()
        except NodeDied as died:
            self._progress.say(process.last_lines())
            if process.name != VIEWER or not self._ready:
                raise
            self._processes.remove(process)
            self._progress.say(f"{died}\nthe run goes on without its page")

    def _take_what_came(self) -> None:
        newest, begun = self.recorder.newest, time.monotonic()
        with self._spinning:
            self._executor.spin_once(timeout_sec=0.0)
            while not self._may_be_more and (left := begun + TAKING_PERIOD - time.monotonic()) > 0.0:
                self._executor.spin_once(timeout_sec=left)
        self._may_be_more = self._topics.take()
        waited = min(time.monotonic() - begun, LONGEST_STEP)
        self._silence = 0.0 if self.recorder.newest is not newest else self._silence + waited

    def spin_meanwhile(self) -> None:
        """Lets the node's clock and its own subscriptions go on while the thread that steps does something else."""
        if self._spinning.acquire(blocking=False):
            try:
                for _ in range(AT_ONCE):
                    self._executor.spin_once(timeout_sec=0.0)
            finally:
                self._spinning.release()

    def wait(self, condition: Callable[[], bool], patience: float, complaint: Callable[[], str]) -> None:
        """Steps until `condition()`.

        Raises:
            GraphError: with `complaint()`, after `patience` [s].
        """
        deadline = time.monotonic() + patience
        while not condition():
            if time.monotonic() > deadline:
                raise GraphError(complaint() + self.frozen)
            self.step()

    def catch_up(self) -> None:
        """Steps until the newest pose is not LATE.

        Raises:
            GraphError: poses stay late for CATCH_UP_PATIENCE.
        """
        self.wait(lambda: self.recorder.lateness <= LATE, CATCH_UP_PATIENCE, self._too_slow)

    def wait_until_poses_come(self) -> None:
        """Waits until every node has reported and poses come."""
        self.wait(self._all_reported(), READY_PATIENCE, self._unready)
        self._refuse_duplicates()
        self.wait(lambda: self._robot_status.level != ERROR, LINK_PATIENCE, self._robot_problem)
        self._turn_off_impact_detection()
        self.wait(lambda: self.recorder.newest is not None, INPUT_PATIENCE, self._no_pose)

    @property
    def late_commands(self) -> int:
        """Commands so far that were too old when the robot was to follow them, by its newest report."""
        return sum(int(item.value) for item in self._robot_status.values if item.key in LATE_COMMANDS)

    def wait_until_ready(self) -> None:
        """Waits until every node has reported, poses and scans come, and the planner listens for a goal."""
        recorder = self.recorder
        self.wait_until_poses_come()
        self.wait(lambda: recorder.scan_came, INPUT_PATIENCE, self._no_scan)
        self.wait(lambda: self._goals.get_subscription_count() > 0, INPUT_PATIENCE, self._no_planner)
        self.wait(lambda: self._robot_knows_planner, INPUT_PATIENCE, lambda: self._missing("robot/state", "reliable"))
        self._commanders_due = 0.0
        self._refuse_other_commanders()
        self._ready = True

    def refuse_kept_stop(self) -> None:
        """Where the robot has kept an emergency stop, waits until somebody clears it, however long that takes.

        Nothing drives off by that: then it ends, for whoever starts it again.

        Raises:
            GraphError: the emergency stop has been cleared.
        """
        why = self.recorder.emergency_stop
        if not why:
            return
        self._progress.say(
            f"{why}: call {self._name('clear_estop')}, or press Clear emergency stop on the page; Ctrl-C ends"
        )
        self.wait(lambda: not self.recorder.emergency_stop, math.inf, str)
        raise GraphError("the emergency stop is cleared: start again to drive")

    def _refuse_other_commanders(self) -> None:
        if time.monotonic() < self._commanders_due:
            return
        self._commanders_due = time.monotonic() + COMMANDERS_PERIOD
        others = other_commanders(self.node, COMMANDER)
        if others:
            topic = self._name(TOPIC)
            raise GraphError(f"{topic} is published by {in_words(others)} beside {COMMANDER}; end all but {COMMANDER}")

    def give_goal(self, goal: np.ndarray) -> None:
        """Publishes a goal (2,) [m] and waits for the planner's answer."""
        self.recorder.ask(goal)
        again = 0.0

        def answered() -> bool:
            nonlocal again
            if time.monotonic() >= again:
                self._goals.publish(goal_to_message(goal, self._preparation.settings.frames.map, self.pose.stamp))
                again = time.monotonic() + GOAL_PERIOD
            return self.recorder.goal is not None

        self.wait(answered, INPUT_PATIENCE, self._no_planner)

    def cancel_goal(self) -> None:
        """Asks the planner to end the goal; what it says of it comes as its status."""
        if self._cancel.service_is_ready():
            self._cancel.call_async(Trigger.Request())

    @property
    def at_rest(self) -> bool:
        """Whether the robot is commanded to rest and does, by a pose sent after the command."""
        newest = self.recorder.newest
        return newest is not None and newest.sent > self.recorder.stands_since and self._speed <= REST_SPEED

    @property
    def _speed(self) -> float:
        pose = self.recorder.newest
        return math.inf if pose is None else math.hypot(pose.vx, pose.vy)

    @property
    def frozen(self) -> str:
        """The nodes that report no more although their processes run, to be added to a sentence; empty without any.

        Where all report: the one that simulated time waited for until it went on without it.
        """
        silent = self.recorder.silent(LONGEST_SILENCE)
        found = [
            f"{name} for {silent[self.full_name(name)]:.1f} s"
            for name in self._preparation.programs
            if self.full_name(name) in silent
        ]
        if found:
            return f"; frozen: nothing on /diagnostics from {in_words(found)}"
        lockstep = self.recorder.lockstep
        if lockstep is None or lockstep.longest_wait <= self._preparation.settings.simulator.patience:
            return ""
        return f"; {lockstep.waited_for} did not run: simulated time waited {lockstep.longest_wait:.2f} s for it"

    def full_name(self, node: str) -> str:
        """Full name of a node of this graph."""
        return full_name(self._preparation.namespace, node)

    def last_message(self, node: str) -> str:
        """Message of a node's newest health report; "" before the first."""
        status = self.recorder.reported.get(self.full_name(node))
        return "" if status is None else status.message

    def _open_node(self, stack: ExitStack) -> None:
        context = Context()
        context.init()
        stack.callback(context.try_shutdown)
        remapped = ["--ros-args", *self._remapping()]
        settings = self._preparation.settings
        if self._commands and settings.simulator.publishes_clock:
            remapped += SIMULATED_TIME
        self.node = PollingNode(NAME, context=context, namespace=self._preparation.namespace, cli_args=remapped)
        stack.callback(self.node.destroy_node)
        self.local_clock = local_clock(self.node)
        self.local_time = partial(seconds, self.local_clock)
        """The local clock [s]; the simulation's where the graph goes by that."""
        times = SendTimes()
        if self._is_recorded:
            self._recording = self._begun_recording(stack, times.ahead_at_first)
        known = recorded_topics(settings, real_scans=LIDAR not in self._preparation.programs)
        topics = self._topics = GraphTopics(self.node, known, times, self._recording)
        mark = self._recording.describe if self._recording else _nowhere
        self.recorder = Recorder(topics, settings, mark, times, self._preparation.namespace)
        self._cancel = self.node.create_client(Trigger, "cancel")
        self._goals = self.node.create_publisher(PoseStamped, "goal_pose", EVENT)
        topics.listen("robot/state", self._take_robot_state)
        self._executor = events_executor(context)
        self._executor.add_node(self.node)
        stack.callback(self._executor.shutdown)

    def _begun_recording(self, stack: ExitStack, clock_ahead: int) -> RecordingFile:
        preparation, folder = self._preparation, self._folder
        recording = RecordingFile(folder.recording)
        stack.callback(recording.finish)
        goal, simulated = preparation.goal.tolist(), preparation.robot.simulated
        describe_run(
            recording, folder.parameters, preparation.world, goal, simulated, preparation.namespace, clock_ahead
        )
        return recording

    def _take_robot_state(self, message: DiagnosticStatus, _: float) -> None:
        self.robot_waits = message.message
        # a goal is new to the robot, and lets it move, only after it has heard of the planner
        self._robot_knows_planner = ("knows_planner", "yes") in [(item.key, item.value) for item in message.values]

    def _ros_arguments(self, name: str) -> list[str]:
        namespace = f"__ns:={self._preparation.namespace}"
        arguments = ["--params-file", str(self._folder.parameters), "-r", namespace, *self._remapping()]
        if self._preparation.settings.simulator.publishes_clock:
            arguments += SIMULATED_TIME
        if self._preparation.robot.emulated and name in SERIAL_ENDS:
            arguments += ["-p", f"{SERIAL_ENDS[name]}:={self._folder.serial}"]
        return arguments

    def _remapping(self) -> list[str]:
        """Keeps a simulation's clock in its own namespace: ROS has one for all robots of a domain, /clock."""
        return ["-r", "/clock:=clock"]

    def _stop_processes(self) -> None:
        try:
            self._stop(COMMANDER)
            if self.recorder.recording:
                self._record_to_the_end()
            self._stop(PLANNER)
            self._topics.take_all()
        finally:
            devices = self._preparation.robot.nodes[1:]
            for name in stop_all(self._processes, devices):
                self._progress.say(f"{name} did not stop when asked to and was killed")
            self._topics.take_all()

    def _stop(self, name: str) -> None:
        stop([process for process in self._processes if process.name == name])

    def _record_to_the_end(self) -> None:
        """Takes what comes until the robot rests and its record is whole, while poses come."""
        self._silence = 0.0
        # a controller that has died sends no zero, but the robot stands by itself
        self._take_until(lambda: self.at_rest, ZERO_PATIENCE)
        self._take_until(lambda: self._speed <= REST_SPEED, REST_PATIENCE)
        self.recorder.finish()
        self._take_until(lambda: self.recorder.is_complete, WHOLE_PATIENCE)
        if self._recording is not None:
            self._recording.flush()

    def _take_until(self, condition: Callable[[], bool], patience: float) -> None:
        deadline = time.monotonic() + patience
        while not condition() and self._silence < SILENCE and time.monotonic() < deadline:
            self._take_what_came()

    def _names(self) -> Counter[str]:
        """Number of visible nodes for each name of this graph, in its namespace."""
        ours = {NAME, *self._preparation.programs}
        seen = self.node.get_node_names_and_namespaces()
        return Counter(name for name, space in seen if space == self._preparation.namespace and name in ours)

    def _refuse_running_nodes(self) -> None:
        end = time.monotonic() + LISTENING_TIME
        while time.monotonic() < end:
            self.step()
            others = sorted((self._names() - Counter([NAME])).keys())
            if others:
                raise StartError(f"{in_words(others)} already in {self._where}; end it, or set another ROS_DOMAIN_ID")

    def _refuse_duplicates(self) -> None:
        duplicates = sorted(name for name, count in self._names().items() if count > 1)
        if duplicates:
            raise GraphError(f"another {in_words(duplicates)} in {self._where}; end it, or set another ROS_DOMAIN_ID")

    def _all_reported(self) -> Callable[[], bool]:
        notice = time.monotonic() + NOTICE_TIME

        def condition() -> bool:
            nonlocal notice
            silent = self._silent_nodes()
            if silent and time.monotonic() > notice:
                self._progress.say(
                    f"waiting for {in_words(silent)} (slow on a busy machine, or before the first compile)"
                )
                notice = float("inf")
            return not silent

        return condition

    @property
    def _robot_status(self) -> DiagnosticStatus:
        return self.recorder.reported[self.full_name(self._preparation.robot.nodes[0])]

    def _robot_problem(self) -> str:
        return f"{self._preparation.robot.nodes[0]}: {self._robot_status.message}"

    def _turn_off_impact_detection(self) -> None:
        """Sets mocap.detect_impacts to false if the firmware senses impacts, lest each be published twice."""
        if ("impact_sensing", "yes") not in [(item.key, item.value) for item in self._robot_status.values]:
            return
        client = self.node.create_client(SetParameters, f"{self.full_name('mocap_node')}/set_parameters")
        off = Parameter("mocap.detect_impacts", value=False).to_parameter_msg()
        self.wait(client.service_is_ready, INPUT_PATIENCE, lambda: "mocap_node: no parameter service")
        answer = client.call_async(SetParameters.Request(parameters=[off]))
        self.wait(answer.done, INPUT_PATIENCE, lambda: "mocap_node: no answer to mocap.detect_impacts: false")

    @property
    def _where(self) -> str:
        return described(self._preparation.network, self._preparation.namespace)

    def _silent_nodes(self) -> list[str]:
        return [name for name in self._preparation.programs if self.full_name(name) not in self.recorder.reported]

    def _unready(self) -> str:
        silent = in_words(self._silent_nodes())
        return f"{silent} not ready within {READY_PATIENCE:g} s: nothing on /diagnostics; {self._where}"

    def _no_pose(self) -> str:
        mocap = self._preparation.settings.mocap
        source = f"{self._name(mocap.topic)} ({mocap.reliability.replace('_', ' ')})"
        reported = self.recorder.reported.get(self.full_name("mocap_node"))
        reason = f"; mocap_node: {reported.message}" if reported else ""
        if self._preparation.robot.simulated and mocap.topic != Mocap().topic:
            reason += f"; a simulated robot sends its poses on {self._name(Mocap().topic)}, in no receiver's form"
        return f"{self._missing('mocap/odom', 'reliable')}, made from {source}{reason}"

    def _no_scan(self) -> str:
        if self.recorder.scan_refused:
            return f"scans come on {self._name('scan')} and are refused: {self.recorder.scan_refused}"
        told = self.last_message(PLANNER)
        return self._missing("scan", "best effort") + (f"; {PLANNER}: {told}" if told else "")

    def _too_slow(self) -> str:
        return f"poses come {self.recorder.lateness:.1f} s late: this machine is too slow for the graph"

    def _no_planner(self) -> str:
        goal, status = self._name("goal_pose"), self._name("goal_status")
        return f"no answer on {status} to the goal on {goal} (reliable) for {INPUT_PATIENCE:g} s; {self._where}"

    def _missing(self, topic: str, reliability: str) -> str:
        return f"nothing on {self._name(topic)} ({reliability}) for {INPUT_PATIENCE:g} s; {self._where}"

    def _name(self, topic: str) -> str:
        return str(self.node.resolve_topic_name(topic))
