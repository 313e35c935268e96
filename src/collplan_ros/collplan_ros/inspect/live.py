"""Listens to a robot's topics while somebody drives it by hand, and records what a recording must hold."""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from importlib import import_module
from pathlib import Path

from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy

from collplan_core.clock_steps import SendTimes
from collplan_ros.inspect.recording import COMMANDS, SCAN, TRANSFORMS, RecordingError
from collplan_ros.messages.mocap_formats import FORMATS
from collplan_ros.messages.qos import EVERY_LATCHED, EVERY_ONE, EVERY_UNRELIABLE
from collplan_ros.node_kit.stop_signal import StopSignal
from collplan_ros.run.graph_topics import GraphTopics, PollingNode
from collplan_ros.run.topics import RecordedTopic
from collplan_ros.run.writer import RecordingFile

LOOK_PERIOD = 0.05
"""Time between two looks for messages and new topics [s]: queues hold seconds."""
LISTENED = {SCAN, *COMMANDS, *(each.message for each in FORMATS.values())}
"""Names of the types that are recorded; TFMessage is among them."""


def record_live(path: Path, duration: float, said: Callable[[float], None]) -> None:
    """Records into a new file at `path` for a time [s] or until Ctrl-C; `said` takes the share of it that is over.

    RecordingError: ROS does not start, or there is no topic to record; then there is no file. RecordError: the file
    cannot be written.
    """
    context, stop, known = Context(), StopSignal(), dict[str, RecordedTopic]()
    with stop.listening(), ExitStack() as stack:
        stack.callback(context.try_shutdown)
        try:
            context.init()
            node = PollingNode("inspect", context=context)
        except RuntimeError as error:  # rcl's own, about its environment
            raise RecordingError(f"ROS does not start: {' '.join(str(error).split())}") from None
        stack.callback(node.destroy_node)
        recording, begun = RecordingFile(path), time.monotonic()
        stack.callback(recording.finish)
        topics = GraphTopics(node, {}, SendTimes(), recording)
        while stop.number is None and (over := time.monotonic() - begun) < duration:
            for each in _new(node, known):
                known[each.name] = each
                topics.add(each)
            topics.take_all()
            recording.flush_when_due()
            said(over / duration)
            time.sleep(LOOK_PERIOD)
        topics.take_all()
    if not known:
        path.unlink()
        raise RecordingError("no topic of poses or scans, expected some: do the robot's nodes run in this domain?")


def _new(node: Node, known: dict[str, RecordedTopic]) -> Iterator[RecordedTopic]:
    """The topics that somebody publishes, of one type that is recorded and installed, and are not known."""
    for name, (kind, *others) in node.get_topic_names_and_types():
        package, _, message = kind.partition("/msg/")
        publishers = [] if name in known or others else node.get_publishers_info_by_topic(name)
        if publishers and message in LISTENED:
            reliable = all(each.qos_profile.reliability == ReliabilityPolicy.RELIABLE for each in publishers)
            qos = EVERY_LATCHED if name.endswith(TRANSFORMS) else EVERY_ONE if reliable else EVERY_UNRELIABLE
            with suppress(ImportError):
                yield RecordedTopic(name, getattr(import_module(f"{package}.msg"), message), qos)
