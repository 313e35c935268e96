"""What the nodes of a graph send, kept with the time at which each sent it."""

import math
from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from collplan_core.clock_steps import SendTimes
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT, LATCHED, POSE_SUBSCRIBED
from collplan_ros.messages.status_values import values_of
from collplan_ros.node_kit.inputs import with_info

KEPT = 20_000
"""Messages kept of each stream."""
STALL, LOST = 0.075, 0.025
"""Longer a node that sends every 0.05 s was stalled by the machine; of that the firmware's clock has lost LOST [s]."""
AT_REST, CREEP = 0.03, 0.06
"""A robot at rest is slower, and has moved where it is faster [m/s]."""


class Commanded(NamedTuple):
    """Whether a command moves the robot, and when it was sent [s, steady clock]."""

    sent: float
    moves: bool


class Motion(NamedTuple):
    """Where the robot truly was [m] and in which frame, or a pose of the motion capture, without a speed [m/s]."""

    sent: float
    x: float
    y: float
    speed: float = math.nan
    frame: str = ""


class Said(NamedTuple):
    """A node's word: its state or status, and the reason."""

    sent: float
    what: Any
    why: str = ""


class WheelStop(NamedTuple):
    """The firmware has set the wheels to zero: how many times by now, and the age of the command then [s]."""

    sent: float
    count: int
    age: float


class Streams:
    """Listens to what faults are measured by."""

    def __init__(self, node: Node, commands: str, truth: str) -> None:
        """Subscribes through `node`; `commands` is the topic of what counts as sent, `truth` of the true motion."""
        # what came, in the order of receipt
        self.commands, self.truth, self.poses, self.refusals, self.states, self.stops = (
            deque[Any](maxlen=KEPT) for _ in range(6)
        )
        # when the firmware told for how long it was held up so far, and how long [s]
        self.losses: deque[tuple[float, float]] = deque(maxlen=KEPT)
        # newest report of each node by its name, with the time it was sent [s, steady clock]
        self.health: dict[str, tuple[float, DiagnosticStatus]] = {}
        self._times, self._node = SendTimes(), node
        self._listen(Twist, commands, self._take_command, EVENT)
        self._listen(Odometry, truth, self._take_truth, EVENT)
        self._listen(Odometry, "mocap/odom", self._take_pose, POSE_SUBSCRIBED)
        self._listen(String, "mocap/refused", lambda m, sent: self.refusals.append(Said(sent, m.data)), POSE_SUBSCRIBED)
        self._listen(DiagnosticStatus, "robot/state", self._take_state, LATCHED)
        self._listen(DiagnosticArray, "/diagnostics", self._take_health, DIAGNOSTICS_SUBSCRIBED)

    def _listen(self, kind: type, topic: str, take: Callable[[Any, float], None], qos: QoSProfile) -> None:
        def timed(message: Any, info: dict[str, Any]) -> None:
            take(message, self._times.steady(1e-9 * info["source_timestamp"]))

        self._node.create_subscription(kind, topic, with_info(timed), qos)

    def _take_command(self, message: Twist, sent: float) -> None:
        self.commands.append(Commanded(sent, bool(message.linear.x or message.linear.y or message.angular.z)))

    def _take_truth(self, message: Odometry, sent: float) -> None:
        place, linear = message.pose.pose.position, message.twist.twist.linear
        self.truth.append(Motion(sent, place.x, place.y, math.hypot(linear.x, linear.y), message.header.frame_id))

    def _take_pose(self, message: Odometry, sent: float) -> None:
        place = message.pose.pose.position
        self.poses.append(Motion(sent, place.x, place.y))

    def _take_state(self, message: DiagnosticStatus, sent: float) -> None:
        self.states.append(Said(sent, values_of(message).get("state"), message.message))

    def _take_health(self, message: DiagnosticArray, sent: float) -> None:
        for status in message.status:
            self.health[status.name.rpartition("/")[2]] = sent, status
            values = values_of(status)
            if "time_stalled" in values:
                self.losses.append((sent, float(values["time_stalled"])))
            if "stop_age" in values and (not self.stops or int(values["stops"]) != self.stops[-1].count):
                self.stops.append(WheelStop(sent, int(values["stops"]), float(values["stop_age"])))

    # ---- what they tell

    def why_mocap_stalled(self, first: float, end: float) -> str:
        """Whether mocap_node stalled once it had stamped the message of time `first`, until `end` [s], in words."""
        told = sorted((row for row in (*self.poses, *self.refusals) if row.sent >= first), key=lambda row: row.sent)
        following = next((row.sent for row in told if row.sent > end), end)
        return why_stalled("mocap_node", told, math.nextafter(first, math.inf), following)

    def motion_at(self, when: float) -> Motion:
        """The robot's true motion at a time [s, steady clock]."""
        rows = list(self.truth)
        return rows[max(bisect_right(rows, when, key=lambda row: row.sent) - 1, 0)]

    def why_stood(self, when: float) -> str:
        """Whether the robot was commanded to stand already then, in words: no fault can be seen to stop it."""
        before = [row for row in self.commands if row.sent <= when]
        return "" if before and before[-1].moves else "the robot stood already"

    def speed_and_way(self, when: float) -> dict[str, float]:
        """The speed at a time [m/s], and the way from then on until the robot was at rest, or until now [m]."""
        rows = [self.motion_at(when), *(row for row in self.truth if row.sent > when)]
        end = next((k for k, row in enumerate(rows) if k and row.speed < AT_REST), len(rows))
        way = sum(math.hypot(after.x - row.x, after.y - row.y) for row, after in pairwise(rows[: end + 1]))
        return {"speed": rows[0].speed, "distance": way}

    def stands_from(self, when: float) -> float | None:
        """When the first of the zero commands was sent that only zeros followed, from `when` on; None without."""
        rows = list(self.commands)
        rows = rows[bisect_left(rows, when, key=lambda row: row.sent) :]
        moving = [k for k, row in enumerate(rows) if row.moves]
        following = moving[-1] + 1 if moving else 0
        return rows[following].sent if following < len(rows) else None

    def why_moved(self, when: float) -> str:
        """Whether a robot that was at rest has moved since then, in words; empty where it has not."""
        fastest = max((row.speed for row in self.truth if row.sent > when), default=0.0)
        return f"it moved, at {fastest:.2f} m/s" if fastest > CREEP else ""


def why_lost(losses: Iterable[tuple[float, float]], begin: float, end: float) -> str:
    """Why the machine counts as stalled for the firmware, which was held up between two times [s]; else empty."""
    before = [lost for sent, lost in losses if sent <= begin][-1:] or [0.0]
    lost = max((lost for sent, lost in losses if sent <= end), default=0.0) - before[0]
    return f"the firmware did not run for {lost:.2f} s" if lost > LOST else ""


def why_stalled(who: str, rows: Iterable[Any], begin: float, end: float) -> str:
    """Why the machine counts as stalled for a node that has sent these rows; empty where it does not.

    Counts the longest time between two that follow each other until `end`, the one before `begin` with them [s].
    """
    sent = [row.sent for row in rows if row.sent <= end]
    since = max(bisect_left(sent, begin) - 1, 0)
    gap = max((after - before for before, after in pairwise(sent[since:])), default=0.0)
    return f"{who} did not run for {gap:.2f} s" if gap > STALL else ""
