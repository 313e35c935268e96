"""What is watched: bringup's own node, which receives and records all topics, and what a graph lacks, in sentences."""

import math
import time
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack

from rclpy.context import Context

from collplan_core.clock_steps import SendTimes
from collplan_core.parameters import Mocap
from collplan_ros.bringup.ending import StartError
from collplan_ros.bringup.options import COMMANDER, LIDAR, PLANNER
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.progress import in_words
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.node_kit.events_executor import events_executor
from collplan_ros.node_kit.publishers import known_publishers
from collplan_ros.run.description import describe_run
from collplan_ros.run.graph_topics import GraphTopics, PollingNode
from collplan_ros.run.recorder import Recorder
from collplan_ros.run.topics import recorded_topics
from collplan_ros.run.writer import RecordingFile

NAME = "bringup"
TAKING_PERIOD = 0.01  # period at which what has come is taken [s]: to wait for each message costs a multiple of it
LONGEST_STEP = 0.1  # longest time without poses that one step counts: a longer one was stalled by the machine [s]
REST_SPEED = 0.03  # speed below which the robot counts as at rest [m/s]
ZERO_PATIENCE = 0.3
"""Longest wait for the zero of a controller that was stopped: without one the robot stands by itself by then [s]."""
REST_PATIENCE = 5.0  # longest wait for the robot to stop after a run [s]
WHOLE_PATIENCE = 10.0  # longest wait for what is still under way of a run's record [s]
SILENCE = 1.0  # time without poses after which none is waited for while the graph is stopped [s]


class Listener:
    """Receives and records from its construction until `close()`; RecordError where the recording cannot be written."""

    def __init__(self, preparation: Preparation, folder: RunFolder) -> None:
        """Makes the node, and the recording in `folder`; StartError where ROS does not start."""
        self.silence = 0.0
        """Time without poses while messages were taken [s]."""
        self.now: Callable[[], float] = time.monotonic
        """The time for patience [s]."""
        self.spin: Callable[[], None] = self._spin_a_moment
        """Has messages come; in one process it steps the nodes."""
        self._may_be_more = False
        context, namespace = Context(), preparation.namespace
        with ExitStack() as stack:
            stack.callback(context.try_shutdown)
            arguments = ["--ros-args", *preparation.remapped]
            try:
                context.init(args=["--ros-args", "--disable-stdout-logs"] * preparation.options.in_one_process)
                self.node = PollingNode(NAME, context=context, namespace=namespace, cli_args=arguments)
            except RuntimeError as error:  # rcl's own, about its environment
                raise StartError(f"ROS does not start: {' '.join(str(error).split())}") from None
            stack.callback(self.node.destroy_node)
            times = SendTimes()
            self._recording = RecordingFile(folder.recording)
            stack.callback(self._recording.finish)
            about = preparation.world, preparation.goal.tolist(), preparation.robot.simulated, namespace
            describe_run(self._recording, folder.parameters, *about, times.ahead_at_first)
            known = recorded_topics(preparation.settings, real_scans=LIDAR not in preparation.programs)
            self.topics = GraphTopics(self.node, known, times, self._recording)
            self.recorder = Recorder(
                self.topics, preparation.settings, self._recording.describe, times, preparation.namespace
            )
            self.executor = events_executor(context)
            self.executor.add_node(self.node)
            stack.callback(self.executor.shutdown)
            self.close = stack.pop_all().close

    def take(self) -> None:
        """Takes the messages that arrive in TAKING_PERIOD or until the next pose, or at once where they are many."""
        newest, begun = self.recorder.newest, self.now()
        self.spin()
        self._may_be_more = self.topics.take()
        waited = min(self.now() - begun, LONGEST_STEP)
        self.silence = 0.0 if self.recorder.newest is not newest else self.silence + waited
        self._recording.flush_when_due()

    def _spin_a_moment(self) -> None:
        begun = time.monotonic()
        self.executor.spin_once(timeout_sec=0.0)
        while not self._may_be_more and (left := begun + TAKING_PERIOD - time.monotonic()) > 0.0:
            self.executor.spin_once(timeout_sec=left)

    @property
    def speed(self) -> float:
        """Speed by the newest pose [m/s]; infinite before the first."""
        pose = self.recorder.newest
        return math.inf if pose is None else math.hypot(pose.vx, pose.vy)

    @property
    def at_rest(self) -> bool:
        """True where the robot is commanded to rest and rests, by a pose sent after the command."""
        newest = self.recorder.newest
        return newest is not None and newest.sent > self.recorder.stands_since and self.speed <= REST_SPEED

    def record_to_the_end(self) -> None:
        """Takes messages until the robot rests and its record is complete, while poses arrive."""
        if not self.recorder.recording:
            return
        self.silence = 0.0
        # a controller that has died sends no zero, but the robot stands by itself
        self._take_until(lambda: self.at_rest, ZERO_PATIENCE)
        self._take_until(lambda: self.speed <= REST_SPEED, REST_PATIENCE)
        self.recorder.finish()
        self._take_until(lambda: self.recorder.is_complete, WHOLE_PATIENCE)
        self._recording.flush()

    def _take_until(self, condition: Callable[[], bool], patience: float) -> None:
        deadline = self.now() + patience
        while not condition() and self.silence < SILENCE and self.now() < deadline:
            self.take()


COMMANDS = "cmd_vel"  # the topic of commands
INPUT_PATIENCE = 3.0  # longest wait for poses, scans and the answer to a goal, once every node is ready [s]
LONGEST_SILENCE = 2.5
"""Time without diagnostics after which a node counts as frozen [s]: each node sends them once a second."""


class Complaints:
    """Sentences about a graph, from what its listener hears."""

    def __init__(self, preparation: Preparation, listener: Listener) -> None:
        self._preparation, self._recorder, self._node = preparation, listener.recorder, listener.node
        self.name = self._node.resolve_topic_name
        """The full name of a topic or service."""

    @property
    def frozen(self) -> str:
        """Nodes that stopped reporting while their processes run, to append to a sentence; "" without any."""
        silent = self._recorder.silent(LONGEST_SILENCE)
        names = {name: self._preparation.full_name(name) for name in self._preparation.programs}
        found = [f"{name} for {silent[full]:.1f} s" for name, full in names.items() if full in silent]
        return f"; frozen: nothing on /diagnostics from {in_words(found)}" if found else ""

    @property
    def silent_nodes(self) -> list[str]:
        """Names of the nodes that have not reported yet."""
        reported = self._recorder.reported
        return [name for name in self._preparation.programs if self._preparation.full_name(name) not in reported]

    def no_pose(self) -> str:
        """Complaint that no poses arrive."""
        mocap = self._preparation.settings.mocap
        source = f"{self.name(mocap.topic)} ({mocap.reliability.replace('_', ' ')})"
        said = self._recorder.status("mocap_node").message
        reason = f"; mocap_node: {said}" if said else ""
        if self._preparation.robot.simulated and mocap.topic != Mocap().topic:
            reason += f"; a simulated robot sends its poses on {self.name(Mocap().topic)}, not in a receiver's format"
        return f"{self.missing('mocap/odom', 'reliable')}, made from {source}{reason}"

    def no_scan(self) -> str:
        """Complaint that scans do not arrive, or cannot be used."""
        if self._recorder.scan_refused:
            return f"scans come on {self.name('scan')} and are refused: {self._recorder.scan_refused}"
        said = self._recorder.status(PLANNER).message
        return self.missing("scan", "best effort") + (f"; {PLANNER}: {said}" if said else "")

    def no_planner(self) -> str:
        """Complaint that a goal is not answered."""
        return f"the goal on {self.name('goal_pose')} is not answered: {self.missing('goal_status', 'reliable')}"

    def too_slow(self) -> str:
        """Complaint that poses arrive late."""
        return f"poses come {self._recorder.lateness:.1f} s late: this machine is too slow for the graph"

    def missing(self, topic: str, reliability: str) -> str:
        """Complaint that nothing arrives on a topic."""
        return f"nothing on {self.name(topic)} ({reliability}) for {INPUT_PATIENCE:g} s; {self._preparation.where}"

    def other_commanders(self) -> str:
        """Complaint that other nodes publish commands too; "" where none does."""
        # a second node of the commander's own name was refused at the start
        others = set(known_publishers(self._node, COMMANDS)) - {self._preparation.full_name(COMMANDER)}
        if not others:
            return ""
        named = f"{self.name(COMMANDS)} is published by {in_words(sorted(others))}"
        return f"{named} beside {COMMANDER}; end all but {COMMANDER}"

    def not_alone(self, own: int) -> str:
        """Complaint that other nodes have the names of this graph, of which its domain holds `own` each; or ""."""
        space = self._preparation.namespace
        seen = Counter(name for name, found in self._node.get_node_names_and_namespaces() if found == space)
        expected = {**dict.fromkeys(self._preparation.programs, own), NAME: 1}
        others = sorted(name for name, count in expected.items() if seen[name] > count)
        who = (f"another {in_words(others)}" if own else f"{in_words(others)} already") if others else ""
        return f"{who} in {self._preparation.where}; end it, or set another ROS_DOMAIN_ID" if who else ""
