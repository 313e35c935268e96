"""What the nodes of a graph send, kept with the time at which each sent it."""

import math
from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Empty, String

from collplan_core.clock_steps import SendTimes
from collplan_core.learning.drive import Drive
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT, LATCHED, POSE_SUBSCRIBED, SENSOR_DATA
from collplan_ros.messages.status_values import drive_from_message, values_of
from collplan_ros.node_kit.inputs import with_info

KEPT = 20_000
"""Messages kept of each stream."""
STALL = 0.075
"""A longer gap in what a node sends every 0.05 s or oftener is a stall of the machine [s]."""
LOST = 0.025
"""The firmware's clock has lost more where it did not run for STALL: it makes up for 0.05 s [s]."""
AT_REST = 0.03
"""[m/s]"""


class Commanded(NamedTuple):
    """A command, when it was sent [s, steady clock], its speed and its velocity in the body's frame [m/s]."""

    sent: float
    moves: bool
    speed: float = 0.0
    x: float = 0.0
    y: float = 0.0


class Motion(NamedTuple):
    """How the robot truly was."""

    sent: float
    x: float
    y: float
    speed: float


class Placed(NamedTuple):
    """A pose of the motion capture, and when mocap_node sent it."""

    sent: float
    x: float
    y: float


class Said(NamedTuple):
    """A node's word: its state or status, and the reason."""

    sent: float
    what: Any
    why: str = ""


class WheelStop(NamedTuple):
    """The firmware has set the wheels to zero: how many times by now, age of the command then [s], and the cause."""

    sent: float
    count: int
    age: float
    cause: str


class Streams:
    """Listens to what faults are measured by.

    Attributes:
        commands, maneuvers, truth, states, goals, stops, beats, refusals, poses, scans: what came, in the order of
            receipt.
        losses: when the firmware told for how long it was held up so far, and how long [s].
        drives: the drives that the controller used, and since when each [s].
        health: newest report of each node by its name, with the time it was sent [s, steady clock].
    """

    def __init__(self, node: Node, commands: str = "cmd_vel", truth: str = "ground_truth/odom") -> None:
        """Subscribes through `node`; `commands` is the topic of what counts as sent, `truth` of the true motion."""
        self.health: dict[str, tuple[float, DiagnosticStatus]] = {}
        self.commands: deque[Commanded] = deque(maxlen=KEPT)
        self.maneuvers: deque[Said] = deque(maxlen=KEPT)
        self.truth: deque[Motion] = deque(maxlen=KEPT)
        self.states: deque[Said] = deque(maxlen=KEPT)
        self.goals: deque[Said] = deque(maxlen=KEPT)
        self.stops: deque[WheelStop] = deque(maxlen=KEPT)
        self.drives: deque[tuple[float, Drive]] = deque(maxlen=KEPT)
        self.losses: deque[tuple[float, float]] = deque(maxlen=KEPT)
        self.beats: deque[float] = deque(maxlen=KEPT)
        self.scans: deque[float] = deque(maxlen=KEPT)
        self.poses: deque[Placed] = deque(maxlen=KEPT)
        self.refusals: deque[Said] = deque(maxlen=KEPT)
        self._times = SendTimes()
        self._node = node
        self._listen(Twist, commands, self._take_command, EVENT)
        self._listen(String, "maneuver", lambda m, sent: self.maneuvers.append(Said(sent, m.data)), LATCHED)
        self._listen(Odometry, truth, self._take_truth, EVENT)
        self._listen(Odometry, "mocap/odom", self._take_pose, POSE_SUBSCRIBED)
        self._listen(String, "mocap/refused", lambda m, sent: self.refusals.append(Said(sent, m.data)), POSE_SUBSCRIBED)
        self._listen(LaserScan, "scan", lambda _, sent: self.scans.append(sent), SENSOR_DATA)
        self._listen(Empty, "planner/heartbeat", lambda _, sent: self.beats.append(sent), EVENT)
        self._listen(GoalStatus, "goal_status", lambda m, sent: self.goals.append(Said(sent, int(m.status))), LATCHED)
        self._listen(DiagnosticStatus, "robot/state", self._take_state, LATCHED)
        self._listen(DiagnosticStatus, "controller/drive", self._take_drive, LATCHED)
        self._listen(DiagnosticArray, "/diagnostics", self._take_health, DIAGNOSTICS_SUBSCRIBED)

    def _listen(self, kind: type, topic: str, take: Callable[[Any, float], None], qos: QoSProfile) -> None:
        def timed(message: Any, info: dict[str, Any]) -> None:
            take(message, self._times.steady(1e-9 * info["source_timestamp"]))

        self._node.create_subscription(kind, topic, with_info(timed), qos)

    def _take_command(self, message: Twist, sent: float) -> None:
        linear = message.linear
        moves = bool(linear.x or linear.y or message.angular.z)
        self.commands.append(Commanded(sent, moves, math.hypot(linear.x, linear.y), linear.x, linear.y))

    def _take_truth(self, message: Odometry, sent: float) -> None:
        place, linear = message.pose.pose.position, message.twist.twist.linear
        self.truth.append(Motion(sent, place.x, place.y, math.hypot(linear.x, linear.y)))

    def _take_pose(self, message: Odometry, sent: float) -> None:
        place = message.pose.pose.position
        self.poses.append(Placed(sent, place.x, place.y))

    def _take_state(self, message: DiagnosticStatus, sent: float) -> None:
        self.states.append(Said(sent, values_of(message).get("state"), message.message))

    def _take_drive(self, message: DiagnosticStatus, sent: float) -> None:
        self.drives.append((sent, drive_from_message(message)))

    def _take_health(self, message: DiagnosticArray, sent: float) -> None:
        for status in message.status:
            self.health[status.name.rpartition("/")[2]] = sent, status
            values = values_of(status)
            if "time_stalled" in values:
                self.losses.append((sent, float(values["time_stalled"])))
            if "stop_age" in values and (not self.stops or int(values["stops"]) != self.stops[-1].count):
                age = float(values["stop_age"])
                self.stops.append(WheelStop(sent, int(values["stops"]), age, values["stop_cause"]))

    # ---- what they tell

    def oldest(self, now: float) -> float:
        """How long ago that one of the streams was sent that is the latest [s]; infinite where one never came."""
        newest = [rows[-1].sent if rows else -math.inf for rows in (self.commands, self.truth, self.poses)]
        newest += [rows[-1] if rows else -math.inf for rows in (self.beats, self.scans)]
        return now - min(newest)

    def largest_acceleration(self, when: float) -> float:
        """The largest acceleration of the drives that the controller used since a time [m/s^2]."""
        rows = list(self.drives)
        first = max(bisect_right(rows, when, key=lambda row: row[0]) - 1, 0)
        return max(drive.max_acceleration for _, drive in rows[first:])

    def why_mocap_stalled(self, first: float, end: float) -> str:
        """Whether mocap_node stalled once it had stamped the message of time `first`, until `end` [s], in words."""
        told = sorted(row.sent for rows in (self.poses, self.refusals) for row in rows if row.sent >= first)
        following = next((sent for sent in told if sent > end), end)
        return why_stalled("mocap_node", told, math.nextafter(first, math.inf), following)

    def motion_at(self, when: float) -> Motion:
        """The robot's true motion at a time [s, steady clock]."""
        rows = list(self.truth)
        return rows[max(bisect_right(rows, when, key=lambda row: row.sent) - 1, 0)]

    def why_stood(self, when: float) -> str:
        """Whether the robot was commanded to stand already then, in words: no fault can be seen to stop it."""
        before = [row for row in self.commands if row.sent <= when]
        return "" if before and before[-1].moves else "the robot stood already"

    def way_since(self, when: float) -> float:
        """Length of the way from a time on until the robot was at rest, or until now [m]."""
        rows = [self.motion_at(when), *(row for row in self.truth if row.sent > when)]
        way = 0.0
        for before, after in pairwise(rows):
            way += math.hypot(after.x - before.x, after.y - before.y)
            if after.speed < AT_REST:
                break
        return way

    def stands_from(self, when: float) -> float | None:
        """When the first of the zero commands was sent that only zeros followed, from `when` on; None without."""
        rows = list(self.commands)
        rows = rows[bisect_left(rows, when, key=lambda row: row.sent) :]
        moving = [k for k, row in enumerate(rows) if row.moves]
        following = moving[-1] + 1 if moving else 0
        return rows[following].sent if following < len(rows) else None


def why_lost(losses: Iterable[tuple[float, float]], begin: float, end: float) -> str:
    """Why the machine counts as stalled for the firmware, which was held up; empty where it does not.

    Args:
        losses: when it told for how long it was held up so far, and how long [s].
        begin, end: the newest word of before `begin` is compared with the newest of until `end` [s].
    """
    rows = list(losses)
    before = [lost for sent, lost in rows if sent <= begin][-1:] or [0.0]
    lost = max((lost for sent, lost in rows if sent <= end), default=0.0) - before[0]
    return f"the firmware did not run for {lost:.2f} s" if lost > LOST else ""


def why_stalled(who: str, sent: Iterable[float], begin: float, end: float) -> str:
    """Why the machine counts as stalled for a node that has sent at these times [s]; empty where it does not."""
    gap = longest_gap(list(sent), begin, end)
    return f"{who} did not run for {gap:.2f} s" if gap > STALL else ""


def longest_gap(times: Sequence[float], begin: float, end: float) -> float:
    """Longest time between two that follow each other, as far as it lies between `begin` and `end` [s]."""
    inside = [time for time in times if begin <= time <= end]
    before = [time for time in times if time < begin][-1:]
    rows = [*before, *inside]
    return max((after - earlier for earlier, after in pairwise(rows)), default=0.0)
