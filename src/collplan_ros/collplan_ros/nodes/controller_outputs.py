"""Outputs of controller_node each period, its line at the terminal when what it does changes, and its statistics."""

import math
import re
from collections import deque

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Point, PointStamped
from rclpy.node import Node
from std_msgs.msg import Float64, String

from collplan_core.command import HAND, STOPPED, WITHOUT_REFERENCE, Command, stopped
from collplan_core.learning.drive import Drive, drive_of
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.drive_watch import DriveWatch
from collplan_core.parameters import Settings
from collplan_ros.messages import qos
from collplan_ros.messages.conversions import command_to_message, command_type, header
from collplan_ros.messages.states import command_in_words, command_to_state, drive_to_message
from collplan_ros.node_kit.run_node import publish_acknowledged

_FIGURES = re.compile(r"-?\d+(\.\d+)?")
DRIVE_PERIOD = 1.0
"""Time between two messages of what was learnt [s]."""


class ControlPeriod:
    """Percentiles of the time between successive commands."""

    def __init__(self, kept: int = 1200) -> None:
        """Keeps the last `kept` periods; the default is a minute at 20 Hz."""
        self._periods: deque[float] = deque(maxlen=kept)
        self._last: float | None = None

    def tick(self, local: float) -> None:
        """Registers a command sent at `local` [s, local clock]."""
        if self._last is not None:
            self._periods.append(local - self._last)
        self._last = local

    @property
    def values(self) -> dict[str, object]:
        """Values of a `Health`: p50 and p99 [ms], and the number of periods n."""
        if not self._periods:
            return {"control_period_ms.n": 0}
        p50, p99 = np.percentile(self._periods, [50, 99])
        return {
            "control_period_ms.p50": 1e3 * float(p50),
            "control_period_ms.p99": 1e3 * float(p99),
            "control_period_ms.n": len(self._periods),
        }


class ControllerOutputs:
    """Publishes cmd_vel, maneuver and controller/: state, reference, motion_delay and drive."""

    def __init__(self, node: Node, settings: Settings) -> None:
        """Publishes through `node`."""
        self.command = stopped("just started")  # the newest sent
        self._settings = settings
        self._log = node.get_logger()
        self._cmd_vel = node.create_publisher(command_type(settings.controller), "cmd_vel", qos.NEWEST_PUBLISHED)
        self._maneuver = node.create_publisher(String, "maneuver", qos.LATCHED)
        self._source = node.get_fully_qualified_name()
        self._state = node.create_publisher(DiagnosticStatus, "controller/state", qos.LATCHED)
        self._said: tuple[str, bool] | None = None
        self._reference = node.create_publisher(PointStamped, "controller/reference", qos.EVENT)
        self._motion_delay = node.create_publisher(Float64, "controller/motion_delay", qos.LATCHED)
        self._told_delay = math.nan
        self._drive = node.create_publisher(DiagnosticStatus, "controller/drive", qos.LATCHED)
        self._told_drive: tuple[Drive | None, str, float] = (None, "", -math.inf)
        self._maneuver.publish(String(data=self.command.maneuver))

    def send(self, command: Command, loop: ControllerLoop, now: float) -> None:
        """Publishes the command of a period at `now` [s, poses' clock], and the topics that change with it."""
        self._cmd_vel.publish(command_to_message(command, now, self._settings))
        if command.maneuver not in WITHOUT_REFERENCE:
            x, y = command.reference.tolist()
            head = header(now, self._settings.frames.map)
            self._reference.publish(PointStamped(header=head, point=Point(x=x, y=y, z=0.0)))
        self._take(command)
        self._tell_delay(loop.motion.verdict.delay)
        self._tell_drive(loop.drive, now)
        self._say(loop, now)

    def words(self, loop: ControllerLoop) -> str:
        """What the robot does at the newest command, in words."""
        return command_in_words(self.command, loop.override_trouble if self.command.maneuver == HAND else "")

    def send_last(self, command: Command, now: float) -> None:
        """Publishes the last command and waits until the robot has received it."""
        self._take(command)
        publish_acknowledged(self._cmd_vel, command_to_message(command, now, self._settings))

    def _take(self, command: Command) -> None:
        if command.maneuver != self.command.maneuver:
            self._maneuver.publish(String(data=command.maneuver))
        self.command = command

    def _tell_delay(self, delay: float) -> None:
        if math.isfinite(delay) and delay != self._told_delay:
            self._motion_delay.publish(Float64(data=delay))
            self._told_delay = delay

    def _tell_drive(self, drive: DriveWatch, now: float) -> None:
        """Publishes the drive where another one is used, and what was learnt each DRIVE_PERIOD."""
        in_use, unlike, told = self._told_drive
        if drive.in_use is None or (drive.in_use == in_use and 0.0 <= now - told < DRIVE_PERIOD):
            return
        belief, shown = drive_of(self._settings.robot), drive.faults.why_unlike
        message = drive_to_message(drive.in_use, drive.learnt, belief, self._source, shown)
        warns = message.message if message.level == DiagnosticStatus.WARN else ""
        if warns and _FIGURES.sub("", warns) != _FIGURES.sub("", unlike):
            self._log.warning(warns)
        self._drive.publish(message)
        self._told_drive = drive.in_use, warns, now

    def _say(self, loop: ControllerLoop, now: float) -> None:
        plan, is_to_move = loop.plan, loop.goal_active or bool(loop.override_trouble)
        reason = self.words(loop)
        # figures in a reason, such as an age, are no change
        said = _FIGURES.sub("", reason), is_to_move
        if said == self._said:
            return
        self._said, stamp = said, None if plan is None else plan.stamp
        self._state.publish(command_to_state(self.command, reason, stamp, is_to_move, self._source))
        if loop.override_trouble or (self.command.maneuver == STOPPED and loop.goal_active):
            self._log.warning(reason)
        else:
            self._log.info(reason)
