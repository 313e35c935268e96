"""Callbacks of a node, called by a test one by one: what it listens to, its timers, its services."""

from rclpy.serialization import serialize_message
from std_srvs.srv import Trigger

from collplan_ros.node_kit import clock


def give(node, topic: str, message, sent: float = 0.0) -> None:
    """Gives a node a message that was sent at this time [s]."""
    info = {"source_timestamp": round(1e9 * sent), "publication_sequence_number": None}
    for subscription in node.subscriptions:
        if subscription.topic_name == f"/{topic}":
            subscription.callback(serialize_message(message) if subscription.raw else message, info)


def tick(node, period: float) -> None:
    """Calls the timer of this period [s]; of several the one that does what the node is for."""
    timers = [timer for timer in node.timers if timer.timer_period_ns == round(1e9 * period)]
    own = [timer for timer in timers if timer.callback.__module__ == clock.__name__]
    own = own or [timer for timer in timers if timer.callback.__self__ is node]
    (timer,) = own or timers
    timer.callback()


def ask(node, service: str) -> Trigger.Response:
    """The answer of a service."""
    (found,) = (each for each in node.services if each.srv_name.removeprefix("/") == service)
    return found.callback(Trigger.Request(), Trigger.Response())
