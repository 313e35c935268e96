"""The journal of a node's loop, published: `planner/journal` and `controller/journal`."""

from rclpy.publisher import Publisher
from std_msgs.msg import String

from collplan_core.replay.journal import Journal


def journal_to(publisher: Publisher, of: str) -> Journal:
    """A journal whose lines are published; `of` as in `Journal`."""
    return Journal(of, lambda line: publisher.publish(String(data=line)))
