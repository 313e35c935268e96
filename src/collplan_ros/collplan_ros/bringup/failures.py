"""Why a run ended before its time."""

NOT_REACHED, NOT_STARTED, GRAPH_LOST = 1, 2, 3
FOUND_WRONG = 1
"""Exit codes."""


class StartError(RuntimeError):
    """Something asked for cannot be done; nothing was started."""


class GraphError(RuntimeError):
    """The graph did not come up or a part of it was lost."""


class NodeDied(GraphError):
    """A node's process ended by itself; the message holds its name, how it ended and its last lines."""


class Interrupted(RuntimeError):
    """A signal asked bringup to stop."""

    def __init__(self, number: int) -> None:
        """Remembers the signal's `number`."""
        super().__init__(f"stopped by signal {number}")
        self.number = number
