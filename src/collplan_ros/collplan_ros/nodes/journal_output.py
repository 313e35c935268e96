"""The journal of a node's loop, published: `planner/journal` and `controller/journal`."""

from rclpy.publisher import Publisher
from std_msgs.msg import String

from collplan_core.replay.journal import Journal, first_scans

FIRST_SCANS = 20
"""Scans that the journal itself holds, a second at 20 Hz: a recorder may find the LIDAR later than the node does."""


def journal_to(publisher: Publisher, of: str) -> Journal:
    """A journal whose lines are published; `of` as in `Journal`."""
    return Journal(of, lambda line: publisher.publish(String(data=line)), first_scans(FIRST_SCANS))
