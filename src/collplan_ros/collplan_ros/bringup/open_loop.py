"""Drives a robot without planner and controller, and keeps where the motion capture saw it."""

import time

import numpy as np
from nav_msgs.msg import Odometry

from collplan_core.command import FREE_SPACE, Command, stopped
from collplan_core.parameters import Settings
from collplan_core.sensing.mocap_body import with_offset
from collplan_core.sensing.pose_filter import PoseSample
from collplan_ros.bringup.failures import GraphError
from collplan_ros.bringup.graph import Graph
from collplan_ros.messages.cmd_vel import command_to_message, command_type
from collplan_ros.messages.conversions import state_from_odometry
from collplan_ros.messages.qos import NEWEST
from collplan_ros.runs.recorder import EVERY_ONE

HALTING_TIME = 0.6
"""Within it the robot stands still [s]."""
RESTING_TIME = 0.4
"""Poses of so long give one mean pose [s]."""


class OpenLoop:
    """Commands by the poses' clock: where poses cease, commands cease, and the robot stops by itself.

    Attributes:
        poses: of the measured body, as they came; received: when, on the local clock [s].
    """

    def __init__(self, graph: Graph, settings: Settings) -> None:
        """Listens and publishes through the graph's node."""
        self.poses: list[PoseSample] = []
        self.received: list[float] = []
        self._graph = graph
        self._settings = settings
        self._publisher = graph.node.create_publisher(command_type(settings), "cmd_vel", NEWEST)
        graph.node.create_subscription(Odometry, "mocap/odom", self._take, EVERY_ONE)

    def refuse_company(self) -> None:
        """Notices others that command the robot.

        Raises:
            GraphError: there are some.
        """
        if self._graph.node.count_publishers("cmd_vel") > 1:
            raise GraphError(f"somebody else publishes on {self._publisher.topic_name}; end it first")

    def drive(self, velocity: tuple[float, float], yaw_rate: float, duration: float) -> list[PoseSample]:
        """Commands a velocity [m/s, robot frame] and a yaw rate [rad/s] for so long [s], then zero until at rest.

        Returns the poses of the whole motion.

        Raises:
            GraphError: no poses any more.
        """
        begun = len(self.poses)
        self._command(Command(np.array(velocity), yaw_rate, FREE_SPACE, np.full(2, np.nan)), duration)
        driven = len(self.poses)
        self._command(stopped("check"), HALTING_TIME)
        return self.poses[begun:driven]

    def rest(self, duration: float = RESTING_TIME) -> list[PoseSample]:
        """The poses of so long a time [s] without commands."""
        begun, count = self._graph.pose.stamp, len(self.poses)
        while self._graph.pose.stamp - begun < duration:
            self._graph.step()
        return self.poses[count:]

    def _command(self, command: Command, duration: float) -> None:
        begun, sent = self._graph.pose.stamp, -np.inf
        try:
            while (now := self._graph.pose.stamp) - begun < duration:
                if now - sent >= 1.0 / self._settings.controller.rate - 1e-6:
                    self._publish(command, now)
                    sent = now
                self._graph.step()
        finally:
            # also where poses cease or somebody presses Ctrl-C
            self._publish(stopped("check"), begun)

    def _publish(self, command: Command, now: float) -> None:
        self._publisher.publish(command_to_message(command, now, self._settings))

    def _take(self, message: Odometry) -> None:
        frames, mocap = self._settings.frames, self._settings.mocap
        state = state_from_odometry(message, frames.map, frames.base)
        robot = PoseSample(state.stamp, state.position, state.yaw)
        self.poses.append(with_offset(robot, mocap.body_offset_x, mocap.body_offset_y, mocap.body_offset_yaw))
        self.received.append(time.monotonic())
