"""Subscriptions of a node that only displays: they end together, and no message ends the node."""

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from collplan_ros.node_kit.inputs import Info, Take, with_info


class ShownTopics:
    """Some subscriptions of a node.

    Attributes:
        refused: number of messages that could not be read.
        newest_refusal: reason of the newest one; empty before the first.
    """

    def __init__(self, node: Node) -> None:
        self.refused = 0
        self.newest_refusal = ""
        self._node = node
        self._subscriptions: list[Subscription] = []

    def listen(self, message_type: type, topic: str, take: Take, qos: QoSProfile, raw: bool = False) -> None:
        """Subscribes; `take` gets the message, or its bytes where `raw`, and what it raises counts as a refusal."""

        def taking(data: bytes, info: Info) -> None:
            if subscription not in self._subscriptions:
                return  # it came while all ended
            # a message of another program may be wrong in any way, and must not end a viewer
            try:
                take(data if raw else deserialize_message(data, message_type), info)
            except Exception as error:
                self.refused += 1
                self.newest_refusal = f"{subscription.topic}: {' '.join(str(error).split())}"

        # as bytes: an executor that cannot read a message raises
        subscription = self._node.create_subscription(message_type, topic, with_info(taking), qos, raw=True)
        self._subscriptions.append(subscription)

    def close(self) -> None:
        """Ends all subscriptions."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._subscriptions.clear()
