"""Publishers of cmd_vel: a robot follows one commander, and stands still where there are two."""

from rclpy.node import Node

from collplan_ros.node_kit.publishers import known_publishers

MOST_BREAKS = 3
"""Breaks in the count of messages within BREAK_TIME that show two publishers; a commander's restart makes one."""
BREAK_TIME = 1.0
"""[s]"""


class Commanders:
    """Publishers of a topic, by the names that ROS lists and by their messages.

    A commander that has restarted is listed twice until the old one's lease ends, under one name: it counts as one. Two
    of one name are distinguished by their messages, which each publisher counts by itself.
    """

    def __init__(self, node: Node, topic: str) -> None:
        """Watches `topic`, as given to rclpy; `look` and `took` are to be called."""
        self.why_refused = ""  # their names in a sentence, where there are several, else empty
        self._node = node
        self._topic = node.resolve_topic_name(topic)
        self._last: int | None = None
        self._breaks: list[float] = []

    def look(self, now: float) -> None:
        """Updates the list of publishers at `now` [s]."""
        listed = known_publishers(self._node, self._topic)
        names = sorted(set(listed))
        self._breaks = [time for time in self._breaks if now - time < BREAK_TIME]
        self.why_refused = ""
        if len(names) > 1:
            self.why_refused = f"{len(names)} nodes publish {self._topic}: {', '.join(names)}; end all but one"
        elif len(self._breaks) >= MOST_BREAKS:
            known = f", both named {names[0]}" if len(listed) > 1 else f": {''.join(names)} and one not yet known"
            self.why_refused = f"two publishers of {self._topic}{known}; end one"

    def took(self, number: int | None, now: float) -> None:
        """Notes a message by its publisher's count of it, None where the middleware gives none, at `now` [s]."""
        if number is None:
            return
        if self._last is not None and number <= self._last:
            self._breaks.append(now)
            if len(self._breaks) >= MOST_BREAKS:
                self.look(now)
        self._last = number
