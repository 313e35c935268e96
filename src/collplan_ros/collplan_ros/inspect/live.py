"""Listens to a robot's topics while somebody drives it by hand, and records what a recording must hold."""

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from importlib import import_module
from pathlib import Path

from rclpy.context import Context
from rclpy.qos import ReliabilityPolicy

from collplan_core.clock_steps import SendTimes
from collplan_ros.inspect.recording import COMMANDS, SCAN, TRANSFORMS, RecordingError
from collplan_ros.messages.mocap_formats import FORMATS
from collplan_ros.messages.qos import EVERY_LATCHED, EVERY_ONE, EVERY_UNRELIABLE
from collplan_ros.node_kit.stop_signal import StopSignal
from collplan_ros.run.graph_topics import GraphTopics, PollingNode
from collplan_ros.run.topics import RecordedTopic
from collplan_ros.run.writer import RecordingFile

LOOK_PERIOD = 0.2
"""Time between two looks for topics that are new [s]."""
TAKING_PERIOD = 0.01
"""Time between two looks for messages [s]: their queues hold seconds."""
LISTENED = {SCAN, *COMMANDS, *(each.message for each in FORMATS.values())}
"""Names of the types that are recorded; TFMessage is among them."""


class Listening:
    """Records each topic of these types from when it is there.

    Attributes:
        known: the topics.
        count: messages received so far.
    """

    def __init__(self, node: PollingNode, recording: RecordingFile) -> None:
        """Listens through `node`."""
        self.known: dict[str, RecordedTopic] = {}
        self.count = 0
        self._node = node
        self._topics = GraphTopics(node, self.known, SendTimes(), recording)

    def look(self) -> None:
        """Subscribes to what is new."""
        for name, kinds in self._node.get_topic_names_and_types():
            publishers = self._node.get_publishers_info_by_topic(name)
            if name not in self.known and publishers and (kind := _class_of(kinds)):
                reliable = all(each.qos_profile.reliability == ReliabilityPolicy.RELIABLE for each in publishers)
                qos = EVERY_LATCHED if name.endswith(TRANSFORMS) else EVERY_ONE if reliable else EVERY_UNRELIABLE
                self.known[name] = RecordedTopic(name, kind, qos)
                self._topics.listen(name, self._hear, raw=True)

    def take(self, until: float) -> None:
        """Takes what has come, and what comes until a time [s, steady clock]."""
        while self._topics.take() or time.monotonic() < until:
            time.sleep(TAKING_PERIOD)

    def _hear(self, data: bytes, sent: float) -> None:
        self.count += 1


def _class_of(kinds: Sequence[str]) -> type | None:
    """The class of a topic's one type, where it is recorded and installed."""
    package, _, message = kinds[0].partition("/msg/")
    if len(kinds) > 1 or message not in LISTENED:
        return None
    try:
        return getattr(import_module(f"{package}.msg"), message, None)
    except ImportError:
        return None


def record_live(path: Path, duration: float, said: Callable[[float], None]) -> None:
    """Records into a new file, for a time or until Ctrl-C.

    Args:
        path: the file; it is removed where nothing came.
        duration: [s].
        said: takes the share of the time that is over.

    Raises:
        RecordingError: ROS does not start, or nothing came.
        RecordError: the file cannot be written.
    """
    context, stop = Context(), StopSignal()
    with stop.listening(), ExitStack() as stack:
        stack.callback(context.try_shutdown)
        try:
            context.init()
            node = PollingNode("inspect", context=context)
        except RuntimeError as error:  # rcl's own, about its environment
            raise RecordingError(f"ROS does not start: {' '.join(str(error).split())}") from None
        stack.callback(node.destroy_node)
        recording = RecordingFile(path)
        stack.callback(recording.finish)
        heard, begun = Listening(node, recording), time.monotonic()
        while stop.number is None and (over := time.monotonic() - begun) < duration:
            heard.look()
            heard.take(begun + min(over + LOOK_PERIOD, duration))
            recording.flush_when_due()
            said(over / duration)
        heard.take(time.monotonic())
    if not heard.count:
        path.unlink()
        raise RecordingError(f"no message on {', '.join(heard.known) or 'any topic'}, expected poses and scans")
