"""bringup's own node: receives the other nodes' messages, for the recording and for monitoring the run."""

import math
import time
from collections.abc import Callable
from contextlib import ExitStack

from rcl_interfaces.msg import Log
from rclpy.context import Context
from rclpy.executors import Executor

from collplan_core.clock_steps import SendTimes
from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.options import LIDAR
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.processes import NodeLogs
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.bringup.stepped_nodes import SteppedNodes
from collplan_ros.node_kit.events_executor import events_executor
from collplan_ros.run.description import describe_run
from collplan_ros.run.graph_topics import GraphTopics, PollingNode
from collplan_ros.run.recorder import Recorder
from collplan_ros.run.topics import recorded_topics
from collplan_ros.run.writer import RecordingFile

NAME = "bringup"
TAKING_PERIOD = 0.01
"""Period at which what has come is taken [s]: to wait for each message costs a multiple of it."""
LONGEST_STEP = 0.1
"""Longest time without poses that one step counts [s]: one that takes longer was stalled by the machine."""
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


class Listener:
    """Receives and records from its construction until `close()`.

    Attributes:
        node: bringup's own node.
        recorder: the nodes' newest reports.
        silence: time without poses while messages were taken [s].
        now: the time for patience [s].

    Raises:
        StartError: ROS does not start.
        RecordError: the recording cannot be written; also from methods.
    """

    def __init__(self, preparation: Preparation, folder: RunFolder) -> None:
        """Makes the node, and the recording in `folder`."""
        self.silence = 0.0
        self.now: Callable[[], float] = time.monotonic
        self._spin: Callable[[], None] = self._spin_a_moment
        self._may_be_more = False
        settings, context = preparation.settings, Context()
        with ExitStack() as stack:
            stack.callback(context.try_shutdown)
            arguments = ["--ros-args", *preparation.remapped]
            try:
                quietly = ["--ros-args", "--disable-stdout-logs"] if preparation.in_one_process else []
                context.init(args=quietly)
                self.node = PollingNode(NAME, context=context, namespace=preparation.namespace, cli_args=arguments)
            except RuntimeError as error:  # rcl's own, about its environment
                raise StartError(f"ROS does not start: {' '.join(str(error).split())}") from None
            stack.callback(self.node.destroy_node)
            times = SendTimes()
            self._recording = RecordingFile(folder.recording)
            stack.callback(self._recording.finish)
            goal, simulated = preparation.goal.tolist(), preparation.robot.simulated
            about = preparation.world, goal, simulated, preparation.namespace
            describe_run(self._recording, folder.parameters, *about, times.ahead_at_first)
            known = recorded_topics(settings, real_scans=LIDAR not in preparation.programs)
            self._topics = GraphTopics(self.node, known, times, self._recording)
            self.recorder = Recorder(self._topics, settings, self._recording.describe, times, preparation.namespace)
            self._executor = events_executor(context)
            self._executor.add_node(self.node)
            stack.callback(self._executor.shutdown)
            self.close = stack.pop_all().close

    @property
    def spun(self) -> tuple[PollingNode, Executor]:
        """The node and its executor."""
        return self.node, self._executor

    def spin_with(self, nodes: SteppedNodes, logs: NodeLogs) -> None:
        """Steps the nodes of this process in the place of its own, from now on; `logs` takes what they log."""
        self.now, self._spin = nodes.now, nodes.step
        self.listen_to_logs(logs.take)

    def listen_to_logs(self, take: Callable[[Log], None]) -> None:
        """Hands each message that a node logs to `take`."""
        self._topics.listen("/rosout", lambda message, _: take(message))

    def take(self) -> None:
        """Takes the messages that arrive in TAKING_PERIOD or until the next pose, or at once where they are many."""
        newest, begun = self.recorder.newest, self.now()
        self._spin()
        self._may_be_more = self._topics.take()
        waited = min(self.now() - begun, LONGEST_STEP)
        self.silence = 0.0 if self.recorder.newest is not newest else self.silence + waited
        self._recording.flush_when_due()

    def _spin_a_moment(self) -> None:
        begun = time.monotonic()
        self._executor.spin_once(timeout_sec=0.0)
        while not self._may_be_more and (left := begun + TAKING_PERIOD - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def take_all(self) -> None:
        """Takes all messages received until now, when no node sends any more."""
        self._topics.take_all()

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

    @property
    def speed(self) -> float:
        """Speed by the newest pose [m/s]; infinite before the first."""
        pose = self.recorder.newest
        return math.inf if pose is None else math.hypot(pose.vx, pose.vy)

    def _take_until(self, condition: Callable[[], bool], patience: float) -> None:
        deadline = self.now() + patience
        while not condition() and self.silence < SILENCE and self.now() < deadline:
            self.take()
