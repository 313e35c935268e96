"""Open-loop driving of a robot, without planner and controller, and recording of its measured poses."""

import time
from collections.abc import Callable

import numpy as np
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger

from collplan_core.command import FREE_SPACE, Command, stopped
from collplan_core.parameters import Settings
from collplan_core.sensing.mocap_body import with_offset
from collplan_core.sensing.pose_filter import PoseSample
from collplan_ros.bringup.commanders import TOPIC, other_commanders
from collplan_ros.bringup.failures import GraphError
from collplan_ros.bringup.graph import NAME, Graph
from collplan_ros.bringup.words import in_words
from collplan_ros.messages.cmd_vel import command_to_message, command_type
from collplan_ros.messages.conversions import state_from_odometry
from collplan_ros.messages.qos import EVERY_ONE, NEWEST

HALTING_TIME = 0.6
"""Time within which the robot comes to rest [s]."""
GREETING_TIME = 0.1
"""Time for which the robot is commanded zero first: of its first command it cannot tell the age [s]."""
PATIENCE = 3.0
"""Longest wait for the robot's answer [s]."""
RESTING_TIME = 0.25
"""Time over which poses are averaged to one [s]."""


class OpenLoop:
    """Commands a robot by the poses' clock: without poses there are no commands, and the robot stops by itself.

    Attributes:
        poses: poses of the measured body, in order of receipt.
        received: time of receipt of each pose, on the local clock [s].
    """

    def __init__(self, graph: Graph, settings: Settings) -> None:
        """Subscribes and publishes through the graph's node."""
        self.poses: list[PoseSample] = []
        self.received: list[float] = []
        self._graph = graph
        self._settings = settings
        self._publisher = graph.node.create_publisher(command_type(settings), TOPIC, NEWEST)
        graph.node.create_subscription(Odometry, "mocap/odom", self._take, EVERY_ONE)

    def refuse_other_publishers(self) -> None:
        """Checks that no other node commands the robot.

        Raises:
            GraphError: another node publishes commands.
        """
        others = other_commanders(self._graph.node, NAME)
        if others:
            raise GraphError(f"{self._publisher.topic_name} is published by {in_words(others)} too; end all but {NAME}")

    def resume(self) -> None:
        """Lets the robot move, as a person has agreed to.

        Raises:
            GraphError: it refuses to.
        """
        client = self._graph.node.create_client(Trigger, "resume")
        self._graph.wait(client.service_is_ready, PATIENCE, lambda: "resume: no such service of the robot")
        answer = client.call_async(Trigger.Request())
        self._graph.wait(answer.done, PATIENCE, lambda: "resume: no answer of the robot")
        if not answer.result().success:
            raise GraphError(f"the robot must not move: {answer.result().message}")
        self._command(stopped("check"), GREETING_TIME)

    def drive(
        self, velocity: tuple[float, float], yaw_rate: float, duration: float, is_near: Callable[[PoseSample], bool]
    ) -> list[PoseSample]:
        """Commands a velocity [m/s, robot frame] and a yaw rate [rad/s] for `duration` [s], then zero until at rest.

        It commands zero from the first pose on that is not near.

        Returns:
            The poses received while the velocity was commanded.

        Raises:
            GraphError: poses have ceased.
        """
        begun = len(self.poses)
        command = Command(np.array(velocity), yaw_rate, FREE_SPACE, np.full(2, np.nan))
        self._command(command, duration, lambda: is_near(self.poses[-1]))
        driven = len(self.poses)
        self._command(stopped("check"), HALTING_TIME)
        return self.poses[begun:driven]

    def rest(self, duration: float = RESTING_TIME) -> list[PoseSample]:
        """The poses received within `duration` [s] without commands."""
        begun, count = self._graph.pose.stamp, len(self.poses)
        while self._graph.pose.stamp - begun < duration:
            self._graph.step()
        return self.poses[count:]

    def _command(self, command: Command, duration: float, goes_on: Callable[[], bool] = lambda: True) -> None:
        begun, sent = self._graph.pose.stamp, -np.inf
        try:
            while (now := self._graph.pose.stamp) - begun < duration and goes_on():
                if now - sent >= 1.0 / self._settings.controller.rate - 1e-6:
                    self._publish(command, now)
                    sent = now
                self._graph.step()
        finally:
            # also after an exception: poses ceased, or Ctrl-C
            self._publish(stopped("check"), begun)

    def _publish(self, command: Command, now: float) -> None:
        self._publisher.publish(command_to_message(command, now, self._settings))

    def _take(self, message: Odometry) -> None:
        frames, mocap = self._settings.frames, self._settings.mocap
        state = state_from_odometry(message, frames.map, frames.base)
        robot = PoseSample(state.stamp, state.position, state.yaw)
        self.poses.append(with_offset(robot, mocap.body_offset_x, mocap.body_offset_y, mocap.body_offset_yaw))
        self.received.append(time.monotonic())
