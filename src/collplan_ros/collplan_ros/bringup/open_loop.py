"""Open-loop driving of a robot, without planner and controller, and recording of its measured poses."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf

import numpy as np
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger

from collplan_core.ages import SmallestDelay
from collplan_core.command import FREE_SPACE, Command
from collplan_core.sensing.mocap_body import with_offset
from collplan_core.sensing.pose_filter import PoseSample
from collplan_ros.bringup.check_findings import Interruptions, is_interrupted
from collplan_ros.bringup.complaints import COMMANDS
from collplan_ros.bringup.failures import GraphError
from collplan_ros.bringup.graph import Graph
from collplan_ros.bringup.paced_commands import PacedCommands, PacedMotion
from collplan_ros.messages.conversions import command_to_message, command_type
from collplan_ros.messages.qos import EVERY_ONE, NEWEST
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.messages.status_values import values_of

HALTING_TIME = 0.6
"""Time within which the robot comes to rest [s]."""
GREETING_TIME = 0.1
"""Time for which the robot is commanded zero first: the age of its first command is unknown to it [s]."""
PATIENCE = 3.0
"""Longest wait for the end of a motion beyond its time [s]."""
RESTING_TIME = 0.25
"""Time over which poses are averaged to one [s]."""
LATE_COMMANDS = ("late", "expired")
"""Figures of a robot's report: commands too old when they came, and those that became so before the next one came."""


class InterruptedTooOften(RuntimeError):
    """Error of a check with so many interrupted motions that further ones are not worth driving."""


class OpenLoop:
    """Drives the robot by commands at a steady rate while poses arrive; without poses it is commanded zero.

    Attributes:
        poses: poses of the measured body, in order of receipt.
        received: time of receipt of each pose, on the local clock [s].
        interruptions: interruptions of the motions driven so far.
    """

    def __init__(self, graph: Graph) -> None:
        """Subscribes and publishes through bringup's node."""
        self.poses: list[PoseSample] = []
        self.received: list[float] = []
        self.interruptions = Interruptions()
        self._graph = graph
        self._listener = listener = graph.listener
        self._settings = settings = graph.preparation.settings
        self.now = listener.local_time
        """The local clock [s]."""
        self._delay = SmallestDelay()
        self._publisher = listener.node.create_publisher(command_type(settings.controller), COMMANDS, NEWEST)
        self._late_before = 0
        self._is_commanding = False
        self._is_near: Callable[[PoseSample], bool] | None = None
        listener.node.create_subscription(Odometry, "mocap/odom", self._take, EVERY_ONE, raw=True)

    @contextmanager
    def resumed(self) -> Iterator[None]:
        """Lets the robot move, as a person has agreed to, until left; the last command is zero.

        Raises:
            GraphError: it refuses to.
        """
        answer = self._graph.call(Trigger, "resume", Trigger.Request())
        if not answer.success:
            raise GraphError(f"the robot must not move: {answer.message}")
        with self.commanding():
            yield

    @contextmanager
    def commanding(self) -> Iterator[None]:
        """Commands zero, and the motions that are driven, until left."""
        self._pass(0.0)
        self._late_before = self._late_commands - self.interruptions.refused
        try:
            go_on = self._listener.spin_meanwhile if self._graph.stepped is None else None
            with PacedCommands(self._publish, 1.0 / self._settings.controller.rate, self.now, go_on) as self._commands:
                self._is_commanding = True
                self._pass(GREETING_TIME)
                yield
        finally:
            self._is_commanding = False

    def drive(
        self, velocity: tuple[float, float], yaw_rate: float, duration: float, is_near: Callable[[PoseSample], bool]
    ) -> list[PoseSample]:
        """Commands a velocity [m/s, robot frame] and a yaw rate [rad/s] for `duration` [s], then zero until at rest.

        It commands zero from the first pose on that is not near.

        Returns:
            The poses measured while the velocity was commanded; none where something interrupted that.

        Raises:
            GraphError: poses have ceased, or the robot does not move any more.
            InterruptedTooOften: as the name says.
        """
        # poses received before the motion must not end it
        self._pass(0.0)
        count = len(self.poses)
        command = Command(np.array(velocity), yaw_rate, FREE_SPACE, np.full(2, np.nan))
        self._is_near = is_near
        motion = self._commands.begin(command, duration, self._allowed)
        while motion.ended == inf and self.now() < motion.until + PATIENCE:
            self._step()
        self._is_near = None
        self._commands.stop()
        self._pass(HALTING_TIME)
        self._refuse_to_wait()
        return self._driven(motion, count)

    def _refuse_to_wait(self) -> None:
        recorder = self._graph.recorder
        if recorder.held:
            # robot_waits advises a new goal or resume, which release the robot but do not continue the check
            raise GraphError(
                f"the robot is held, {recorder.held}: this machine may be too slow or too busy; start the check again"
            )
        if recorder.robot_waits:
            raise GraphError(f"the robot does not move any more: {recorder.robot_waits}")

    def rest(self, duration: float = RESTING_TIME) -> list[PoseSample]:
        """The poses measured within `duration` [s] from now on."""
        count, begun = len(self.poses), self.now()
        self._pass(duration)
        return self._between(count, begun, inf)

    def _driven(self, motion: PacedMotion, count: int) -> list[PoseSample]:
        """The poses measured during a motion, of those after the first `count`; none if it was interrupted."""
        poses = self._between(count, motion.begun, motion.ended)
        ends = motion.begun - self._shift, motion.ended - self._shift
        between_poses = float(np.diff([ends[0], *(pose.stamp for pose in poses), ends[1]]).max())
        interrupted = motion.has_lapsed or is_interrupted(motion.gap, between_poses, self._settings.limits)
        before, refused = self.interruptions, self._late_commands - self._late_before
        self.interruptions = Interruptions(before.motions + 1, before.interrupted + interrupted, refused)
        if self.interruptions.are_hopeless:
            raise InterruptedTooOften
        return [] if interrupted else poses

    def _between(self, count: int, begun: float, ended: float) -> list[PoseSample]:
        """The poses measured between two local times [s], of those after the first `count`."""
        shift = self._shift
        return [pose for pose in self.poses[count:] if begun <= pose.stamp + shift <= ended]

    @property
    def _late_commands(self) -> int:
        """Commands so far that were too old when the robot was to follow them, by its newest report."""
        values = values_of(self._graph.recorder.status(self._graph.preparation.robot.nodes[0]))
        return sum(int(values.get(key, 0)) for key in LATE_COMMANDS)

    @property
    def _shift(self) -> float:
        """Offset from a pose's stamp to the local time, if the fastest pose took no time to arrive [s]."""
        return self._delay.least

    @property
    def _newest(self) -> float:
        """Local time of the newest pose [s], -inf before the first."""
        return self.poses[-1].stamp + self._shift if self.poses else -inf

    @property
    def _allowed(self) -> float:
        """Local time until which the newest pose lets the robot move [s]."""
        return self._newest + self._settings.limits.pose_age

    def _pass(self, duration: float) -> None:
        """Takes messages for `duration` [s], and further until the poses of that time have arrived."""
        end = self.now() + duration
        while self._newest < end:
            self._step()

    def _step(self) -> None:
        self._graph.step()
        # raises where poses have ceased
        _ = self._graph.pose

    def _publish(self, command: Command) -> None:
        self._publisher.publish(command_to_message(command, self.poses[-1].stamp, self._settings))

    def _take(self, raw: bytes) -> None:
        frames, mocap = self._settings.frames, self._settings.mocap
        state = state_from_bytes(raw, frames.map, frames.base)
        robot = PoseSample(state.stamp, state.position, state.yaw)
        self.poses.append(with_offset(robot, mocap.body_offset_x, mocap.body_offset_y, mocap.body_offset_yaw))
        self.received.append(self.now())
        self._delay, _ = self._delay.measured(state.stamp, self.received[-1])
        self._watch(self.poses[-1])
        if self._is_commanding and self._graph.stepped is not None:
            self._commands.look()  # a command that is due: the next pose waits for it

    def _watch(self, pose: PoseSample) -> None:
        """Ends the present motion at a pose that is not near, else lets it go on; in whichever thread takes poses."""
        if self._is_near is None:
            return
        if self._is_near(pose):
            self._commands.allow(self._allowed)
        else:
            self._commands.stop()
