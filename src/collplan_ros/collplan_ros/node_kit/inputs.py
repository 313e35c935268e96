"""The subscriptions of a node, and its log lines about them: whether an input comes, is missing, or is refused."""

import math
import re
from collections import Counter
from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from collplan_core.loop.input_gate import Refusals
from collplan_core.scan import ScanError
from collplan_ros.messages.reading import MessageError
from collplan_ros.node_kit.backlog import Backlog
from collplan_ros.node_kit.clock import local_clock, seconds, steady_clock
from collplan_ros.node_kit.publishers import Senders, known_publishers, why_several

STREAM = "stream"
"""An input that comes all the time: missed when nothing comes."""
STATE = "state"
"""A latched input: missing until it was received, and when no node publishes it any more."""
EVENT = "event"
"""An input that comes when something happens: never missed."""

COMES = "comes"
CONFLICT = "conflict"
"""Keys of lines that are no warnings."""
QUIET_CHECKS = 2
"""Checks in a row without a message after which an input is missed. Checks, not seconds: a stalled node misses none."""

Info = Mapping[str, Any]
"""source_timestamp [ns, wall clock of the sender], publication_sequence_number and more, by name."""
Take = Callable[[Any, Info], None]
"""Takes a message and DDS's information on it."""


def with_info(take: Take) -> Take:
    """The callback to subscribe with, under whichever executor."""

    # rclpy counts the parameters, which `wraps` shows. EventsExecutor (rclpy 7.1.6) gives the two as one tuple
    @wraps(take)
    def taking(*given: Any) -> None:
        message, info = given[0] if len(given) == 1 else given
        take(message, info)

    return taking


TWISTS = {"geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"}
TF = "/tf"
"""The topic that all broadcasters of transforms share."""
ONLY_OTHERS = "but its messages hold nothing for this node"
CHECK_PERIOD = 1.0
"""Time between two looks at the inputs [s]; each logs at most one warning and one line of information."""


class InputWatch:
    """One input, checked at a steady rate: each check reports what has changed since the previous one.

    `need` is STREAM, STATE or EVENT; `publishers` returns for each why its messages can never be received, or "".
    """

    def __init__(self, name: str, need: str, publishers: Callable[[], list[str]]) -> None:
        self.name = name
        self.n_taken = self.n_refused = 0  # messages so far
        self.taken_at = -math.inf  # local time of the newest one taken [s]
        self._need = need
        self.hint = self.dropped = self.conflict = ""
        """What is suspicious of messages taken; why the newest was neither taken nor refused; which contradict each
        other or the settings, and what to do; else empty."""
        self._publishers = publishers
        self._reason = ""
        self._checked = 0, 0
        self._quiet = 0
        self._true: dict[str, str] = {}

    def refused(self, reason: str) -> None:
        """Notes a message that was refused for this reason."""
        self.n_refused += 1
        self._reason = reason

    def check(self) -> dict[str, str]:
        """Lines about changes since the last check, by the key that makes each a new message.

        The key of an input that arrives is COMES, with its name.
        """
        before, self._true = self._true, self._what_is_true()
        # an obstacle told while the input was missing is not told again once it comes from another publisher
        return {fact: text for fact, text in self._true.items() if fact not in before and f"no {fact}" not in before}

    def _what_is_true(self) -> dict[str, str]:
        before, self._checked = self._checked, (self.n_taken, self.n_refused)
        taken, refused = (now - then for now, then in zip(self._checked, before, strict=True))
        publishers = self._publishers()
        stays = not refused and self._need == STATE and self.n_taken > 0 and "" in publishers
        self._quiet = 0 if taken or refused or stays else self._quiet + 1
        if 0 < self._quiet < QUIET_CHECKS:
            return self._true
        true = {COMES: self.name} if (taken or stays) and self._need != EVENT else {}
        if refused:
            kind = re.sub(r"\d+", "#", self._reason)  # other numbers in it do not make it another reason
            # that nothing else arrives is a new message, too
            true[f"{bool(taken)} {kind}"] = f"{self.name} refused: {self._reason}"
        if self.hint:
            true["hint"] = f"{self.name}: {self.hint}"
        if self.conflict:
            true[CONFLICT] = self.conflict
        return true | {line: line for line in self._obstacles(publishers)}

    def _obstacles(self, publishers: list[str]) -> list[str]:
        """Lines about the lack of messages, and about publishers whose messages can never be received."""
        missing = self._quiet > 0 and self._need != EVENT
        silence = (self.dropped if self._quiet else "") or "nothing received" * missing
        reasons = Counter(why or silence for why in publishers)
        found = [f"{counted(n)}, {why}" for why, n in reasons.items() if why]
        if missing and not publishers:
            found = [counted(0)]
        return [f"{'no ' if missing else ''}{self.name}: {each}" for each in found]


def counted(n: int) -> str:
    """A number of publishers in words."""
    return f"{n} publisher{'s' * (n != 1)}"


class Inputs:
    """The subscriptions of a node. It logs when messages arrive, when they are missing or refused, and why.

    Make it first, subscribe through `listen`, and call `ready` at the end of the constructor. From then on it logs a
    line for each change, at most about one a second: docs/troubleshooting.md.

    A callback refuses a message by letting the error of its conversion pass, or by calling `refused`. To do more, it
    catches the error, acts, and raises it again. A refusal is logged once for each reason, numbers aside.
    """

    def __init__(self, node: Node, refusals: Refusals | None = None, backlog: Backlog | None = None) -> None:
        """Subscribes in `node`; counts in `refusals` where given, which others may share.

        A `backlog` drops messages that queue up while the node is frozen, but for latched ones, which hold until the
        next one and arrive only once, and those with `late_counts`.
        """
        self.refusals = Refusals() if refusals is None else refusals  # for the node's diagnostics
        self.sent = 0.0  # send time of the present message, by the wall clock of its sender [s]
        self.number: int | None = None  # of the present message among its publisher's; None where DDS gives none
        self._node = node
        self._backlog = backlog
        self._watches: dict[str, InputWatch] = {}
        self._steady, self._local = steady_clock(), local_clock(node)
        self._senders: dict[str, Senders] = {}
        self._conflicts: dict[str, str] = {}
        self._clock_runs = False

    def listen(
        self,
        message_type: type[Any],
        topic: str,
        callback: Callable[[Any], bool | None],
        qos: QoSProfile,
        need: str = STREAM,
        kind: str = "",
        late_counts: bool = False,
        raw: bool = False,
    ) -> None:
        """Subscribes; `need` is STREAM, STATE or EVENT: whether the input is reported missing when it does not arrive.

        Args:
            callback: takes a message, or its bytes where `raw`. A message counts as refused where it raises
                MessageError or ScanError, and as not meant for this node where it returns False.
            kind: name under which refused messages are counted; the topic where empty.
            late_counts: whether a message counts also where it queued up while the node was frozen.
        """
        # the name after remapping, relative where it is in the node's namespace
        name = self._node.resolve_topic_name(topic).removeprefix(self._node.get_namespace().rstrip("/") + "/")

        def obstacles() -> list[str]:
            expected = type_name(message_type)
            found = self._node.get_publishers_info_by_topic(self._node.resolve_topic_name(topic))
            return [_why_never(publisher.topic_type, expected) for publisher in found]

        watch = InputWatch(name, need, obstacles)
        self._watches[topic] = watch
        latched = qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
        backlog = None if latched or late_counts else self._backlog

        def take(message: Any, info: Info) -> None:
            if backlog is not None and backlog.holds():
                return
            if not latched and not self._has_time():
                watch.dropped = self._why_no_time()
                return
            watch.dropped = ""
            self.sent, self.number = 1e-9 * info["source_timestamp"], info["publication_sequence_number"]
            before = watch.n_refused
            try:
                is_ours = callback(message) is not False
            except (MessageError, ScanError) as error:
                is_ours = True
                self.refused(topic, str(error), kind)
            if is_ours and need == STREAM:
                self.count_sender(topic)
            if is_ours and watch.n_refused == before:
                watch.n_taken += 1
                watch.taken_at = seconds(self._local)
            watch.dropped = "" if is_ours else ONLY_OTHERS

        subscription = self._node.create_subscription(message_type, topic, with_info(take), qos, raw=raw)
        if backlog is not None:
            backlog.watch(subscription)

    def _has_time(self) -> bool:
        """Returns whether a time is known by which to take a message: under /clock none is before its first message."""
        self._clock_runs = self._clock_runs or self._node.get_clock().now().nanoseconds > 0
        return self._clock_runs

    def _why_no_time(self) -> str:
        n = self._node.count_publishers("/clock")
        return f"but no /clock: {counted(n)}{', nothing received later than 0 s' * (n > 0)}, and use_sim_time is true"

    def age(self, topic: str) -> float:
        """Time since the newest message that was taken, by the node's local clock [s]; infinite before the first."""
        return seconds(self._local) - self._watches[topic].taken_at

    def refused(self, topic: str, reason: str, kind: str = "") -> None:
        """Counts a message as refused, as `kind` or its topic; the next look logs the reason.

        To be called from the callback that takes the message, or later where its use fails.
        """
        self._watches[topic].refused(reason)
        self.refusals.add(kind or topic, reason)

    def hint(self, topic: str, text: str) -> None:
        """Notes what is suspicious about a message that is taken, "" for nothing; the first one is logged, once."""
        self._watches[topic].hint = self._watches[topic].hint or text

    def count_sender(self, topic: str) -> None:
        """Notes that one node alone may send messages such as the present one, as those of every STREAM."""
        self._senders.setdefault(topic, Senders()).took(self.number, seconds(self._steady))

    def conflict(self, topic: str, text: str) -> None:
        """Notes what does not fit together, "" for nothing: an error, logged once, and on /diagnostics meanwhile."""
        self._conflicts[topic] = text

    @property
    def conflicts(self) -> list[str]:
        """What does not fit together now, in sentences."""
        return [watch.conflict for watch in self._watches.values() if watch.conflict]

    def publishers(self, topic: str) -> list[str]:
        """Full name of the other node of each publisher of a topic."""
        own = self._node.get_fully_qualified_name()
        return sorted(name for name in known_publishers(self._node, topic) if name != own)

    def _why_several(self, topic: str) -> str:
        """Returns who publishes a topic where messages of several nodes come, and what to do; "" for one."""
        if topic not in self._senders or not self._senders[topic].are_several(seconds(self._steady)):
            return ""
        full = self._node.resolve_topic_name(topic)
        shared = ", at least two of these the same transform" if full == TF else ""
        return why_several(full, self.publishers(topic), True, shared)

    def ready(self, about: str) -> None:
        """Logs that the node is ready, with its topics and its own description, and watches from now on."""
        names = ", ".join(watch.name for watch in self._watches.values())
        self._node.get_logger().info(f"ready: listens to {names}; {about}")
        # steady even where the node follows /clock: a clock that stands still must not hide what is missing
        self._node.create_timer(CHECK_PERIOD, self._check, clock=steady_clock())

    def _check(self) -> None:
        for topic, watch in self._watches.items():
            watch.conflict = self._conflicts.get(topic, "") or self._why_several(topic)
        news = [watch.check() for watch in self._watches.values()]
        coming = [lines.pop(COMES) for lines in news if COMES in lines]
        conflicts = [lines.pop(CONFLICT) for lines in news if CONFLICT in lines]
        warnings = [line for lines in news for line in lines.values()]
        if coming:
            self._node.get_logger().info(f"{', '.join(coming)} {'comes' if len(coming) == 1 else 'come'}")
        if warnings:
            self._node.get_logger().warning("; ".join(warnings))
        if conflicts:
            self._node.get_logger().error("; ".join(conflicts))


def type_name(message_type: type[Any]) -> str:
    """The name of a message class in ROS: nav_msgs/msg/Odometry."""
    package, kind = message_type.__module__.split(".")[:2]
    return f"{package}/{kind}/{message_type.__name__}"


def _why_never(found: str, expected: str) -> str:
    """Returns why messages of a type never come; "" for the expected one. Of QoS that does not fit rclpy warns."""
    if found == expected:
        return ""
    remedy = " (controller.stamped_cmd_vel)" if {found, expected} == TWISTS else ""
    return f"but of type {found}, expected {expected}{remedy}"
