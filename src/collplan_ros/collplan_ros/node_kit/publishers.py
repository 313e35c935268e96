"""The nodes that publish a topic: by their names, as ROS lists them, and by their messages."""

from collections.abc import Sequence

from rclpy.node import Node

from collplan_ros.node_kit.node_names import full_name

UNKNOWN = "_NODE_NAME_UNKNOWN_"
"""Name under which ROS lists a node until it is discovered whole."""
WINDOW = 10.0
"""Time for which a count is remembered [s]: a second publisher may be slow."""
OF_COMMANDS = 1.0
"""The same of commands [s], which come often: whoever ends the second one need not wait."""
MOST_RETURNS = 3
"""Returns to an earlier count within that time that show two publishers. One that has started again never returns."""


def listed_publishers(node: Node, topic: str) -> list[str]:
    """Full name of the node of each publisher of `topic`, as given to rclpy; UNKNOWN for one not discovered whole."""
    found = node.get_publishers_info_by_topic(node.resolve_topic_name(topic))
    return [UNKNOWN if each.node_name == UNKNOWN else full_name(each.node_namespace, each.node_name) for each in found]


def known_publishers(node: Node, topic: str) -> list[str]:
    """Full name of the node of each publisher of `topic`, without those whose discovery is not complete."""
    return [name for name in listed_publishers(node, topic) if name != UNKNOWN]


def why_several(topic: str, listed: Sequence[str], send: bool, what: str = "") -> str:
    """Returns which nodes publish a topic where several are `listed` or `send`, and what to do; "" for one.

    A node that has restarted is listed twice until the old one's lease ends, under one name: it counts as one.
    """
    names = sorted(set(listed))
    if len(names) > 1:
        return f"{len(names)} nodes publish {topic}{what}: {', '.join(names)}; expected one: end all but one"
    known = f", both named {names[0]}" if len(listed) > 1 else f": {''.join(names) or 'one'} and one not yet known"
    return f"two nodes publish {topic}{known}; expected one: end one" if send else ""


class Senders:
    """Whether messages of one topic come from several publishers, by the count that each keeps of its own."""

    def __init__(self, window: float = WINDOW) -> None:
        """Remembers counts for `window` [s]. An idle publisher, or one that has started again, is no second."""
        self._window = window
        self._counts: list[tuple[int, float]] = []
        self._returns: list[float] = []

    def took(self, number: int | None, now: float) -> None:
        """Notes a message by its publisher's count, None where the middleware gives none, at `now` [s, steady]."""
        if number is None:
            return
        self._counts = [each for each in self._counts if now - each[1] < self._window]
        own = max((each for each in self._counts if each[0] < number), default=None)
        if own is not None:
            if own is not self._counts[-1]:
                self._returns.append(now)
            self._counts.remove(own)
        self._counts.append((number, now))

    def are_several(self, now: float) -> bool:
        """Returns whether at least two of them send at `now` [s]."""
        self._returns = [each for each in self._returns if now - each < self._window]
        return len(self._returns) >= MOST_RETURNS


class Commanders(Senders):
    """Publishers of commands: a robot follows one, and stands still where two are listed or send."""

    def __init__(self, node: Node, topic: str) -> None:
        """Watches `topic`, as given to rclpy; `look` and `took` are to be called."""
        super().__init__(OF_COMMANDS)
        self.why_refused = ""  # their names in a sentence, where there are several, else empty
        self._node = node
        self._topic = node.resolve_topic_name(topic)

    def look(self, now: float) -> None:
        """Updates the list of publishers at `now` [s]."""
        self.why_refused = why_several(self._topic, known_publishers(self._node, self._topic), self.are_several(now))
