"""Subscriptions that are asked when there is time, and wake nobody: for a node that only watches.

An executor builds its set of everything it waits for anew at each message, which costs more than the message. A node
that draws twenty times a second asks then, and takes what has come.
"""

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

Take = Callable[[Any, Mapping[str, Any]], None]
"""Takes a message and what DDS says of it."""


class NeverCalled(CallbackGroup):
    """A group whose members no executor waits for."""

    def can_execute(self, entity: object) -> bool:
        return False

    def beginning_execution(self, entity: object) -> bool:
        return False

    def ending_execution(self, entity: object) -> None:
        pass


class PolledSubscriptions:
    """Some subscriptions of a node, each asked by `poll` for what has come since.

    Attributes:
        refused: how many messages could not be read.
        newest_refusal: why not, of the newest one; empty before the first.
    """

    def __init__(self, node: Node) -> None:
        self.refused = 0
        self.newest_refusal = ""
        self._node = node
        self._group = NeverCalled()
        self._taken: list[tuple[Subscription, Take]] = []

    def listen(self, message_type: type, topic: str, take: Take, qos: QoSProfile, raw: bool = False) -> None:
        """Subscribes; `take` gets the message, or its bytes where `raw`, and what it raises counts as a refusal."""
        subscription = self._node.create_subscription(
            message_type, topic, lambda _: None, qos, callback_group=self._group, raw=raw
        )
        self._taken.append((subscription, take))

    def poll(self) -> None:
        """Takes what has come, of each topic in the order in which it came and at most as much as its queue holds."""
        for subscription, take in list(self._taken):
            for _ in range(subscription.qos_profile.depth):
                if not self._took_one(subscription, take):
                    break

    def _took_one(self, subscription: Subscription, take: Take) -> bool:
        """Whether there was a message."""
        # whatever a stranger publishes may be wrong in any way, and a viewer must not end by it
        try:
            with subscription.handle:
                got = subscription.handle.take_message(subscription.msg_type, subscription.raw)
            if got is None:
                return False
            take(*got)
        except Exception as error:
            self.refused += 1
            self.newest_refusal = f"{subscription.topic}: {' '.join(str(error).split())}"
        return True

    def close(self) -> None:
        """Ends all subscriptions."""
        for subscription, _ in self._taken:
            self._node.destroy_subscription(subscription)
        self._taken.clear()
