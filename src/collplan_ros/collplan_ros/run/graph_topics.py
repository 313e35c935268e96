"""Every topic of a graph, each subscribed once: as bytes for the recording, as messages for its listeners."""

import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from collplan_core.clock_steps import SendTimes
from collplan_ros.messages.qos import EVERY_ONE
from collplan_ros.run.schemas import offered_qos, schema_text, type_name
from collplan_ros.run.topics import RecordedTopic
from collplan_ros.run.writer import RecordingFile

Take = Callable[[Any, float], None]
"""Takes a message and its send time [s, steady clock], which its sender's middleware gives, whatever delays it here."""
NANO = 10**9
AT_ONCE = 20
"""Messages of a topic that are taken in a row before the next topic's turn."""


class _NeverCalled(CallbackGroup):
    """A group whose members no executor waits for."""

    def can_execute(self, entity: object) -> bool:
        return False

    def beginning_execution(self, entity: object) -> bool:
        return False

    def ending_execution(self, entity: object) -> None:
        pass


class PollingNode(Node):
    """A node whose executor does not see what is polled: EventsExecutor would call each, whatever its group."""

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Subscriptions that are not polled."""
        return (each for each in super().subscriptions if not isinstance(each.callback_group, _NeverCalled))


class GraphTopics:
    """Takes the received messages whenever it is called.

    An executor that waits for each message spends several times as much on waiting as on the message. One of rclpy's
    leaves these subscriptions alone; for EventsExecutor they must be those of a PollingNode.
    """

    def __init__(
        self, node: Node, topics: Mapping[str, RecordedTopic], times: SendTimes, recording: RecordingFile
    ) -> None:
        """Subscribes through `node` to all `topics`."""
        self._made = partial(_Topic, node, times=times, recording=recording, group=_NeverCalled())
        self._taken = {name: self._made(topic) for name, topic in topics.items()}

    def add(self, topic: RecordedTopic) -> None:
        """Subscribes to one more."""
        self._taken[topic.name] = self._made(topic)

    def listen(self, topic: str, take: Take, raw: bool = False) -> None:
        """Has each message of a known topic, or its bytes where `raw`, handed to `take`; none that cannot be read."""
        of = self._taken[topic]
        (of.takers_of_bytes if raw else of.listeners).append(take)

    def take(self) -> bool:
        """Takes received messages; returns whether there may be more."""
        more = False
        for topic in self._taken.values():
            more = topic.take() or more
        return more

    def take_all(self) -> None:
        """Takes all messages received until now, when no node sends any more."""
        for _ in range(EVERY_ONE.depth // AT_ONCE):
            if not self.take():
                return


class _Topic:
    """One topic, and what takes its messages or their bytes."""

    def __init__(
        self, node: Node, topic: RecordedTopic, times: SendTimes, recording: RecordingFile, group: CallbackGroup
    ) -> None:
        self.listeners: list[Take] = []
        self.takers_of_bytes: list[Take] = []
        self._node = node
        self._topic = topic
        self._times = times
        self._recording = recording
        self._name = node.resolve_topic_name(topic.name)
        self._channel: int | None = None
        self._subscription = node.create_subscription(
            topic.kind,
            topic.name,
            lambda _: None,  # nobody calls it
            topic.qos,
            callback_group=group,
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
            raw=True,
        )

    def take(self) -> bool:
        """Takes received messages, at most AT_ONCE; returns whether there may be more."""
        handle, kind = self._subscription.handle, self._topic.kind
        with handle:
            for _ in range(AT_ONCE):
                taken = handle.take_message(kind, True)
                if taken is None:
                    return False
                self._hand_on(*taken)
        return True

    def _hand_on(self, data: bytes, info: dict[str, Any]) -> None:
        # DDS gives its time of receipt, however late it is taken here
        came = info["received_timestamp"] or time.time_ns()
        stamp = info["source_timestamp"] or came
        ns = round(NANO * self._times.steady(stamp / NANO))
        if self._channel is None:
            self._channel = self._made_channel()
        recorded = ns + self._times.ahead_at_first
        number = info["publication_sequence_number"] or 0
        self._recording.write(self._channel, data, recorded + came - stamp, recorded, number)
        sent = ns / NANO
        for take in self.takers_of_bytes:
            take(data, sent)
        if not self.listeners:
            return
        try:
            message = deserialize_message(data, self._topic.kind)
        except RuntimeError:  # it is none of this kind
            return
        for take in self.listeners:
            take(message, sent)

    def _made_channel(self) -> int:
        kind = type_name(self._topic.kind)
        publishers = self._node.get_publishers_info_by_topic(self._name)
        about = {
            "offered_qos_profiles": offered_qos(publishers),
            "topic_type_hash": str(publishers[0].topic_type_hash) if publishers else "",
        }
        return self._recording.channel(self._name, kind, schema_text(kind), about)
