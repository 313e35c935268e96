"""Exit codes and exceptions of a run that fails."""

import signal

NOT_REACHED, NOT_STARTED, GRAPH_LOST, RECORD_LOST = 1, 2, 3, 4


class StartError(RuntimeError):
    """A request that cannot be fulfilled; nothing was started."""


class GraphError(RuntimeError):
    """The graph did not come up, or a part of it was lost."""

    outcome, exit_code = "graph_lost", GRAPH_LOST


class NodeDied(GraphError):
    """A node's process ended by itself; the message holds its name and how it ended."""

    outcome = "node_died"


class NodeRefused(NodeDied):
    """A node that could not be made of what it was given, as a parameter that does not fit; the message as before."""

    exit_code = NOT_STARTED


class DrivesOn(GraphError):
    """The robot moves, or its own node has held it, after it was told to stand at the end of a run."""

    outcome = "drives_on"


class Interrupted(RuntimeError):
    """A signal asked bringup to stop."""

    outcome = "interrupted"

    def __init__(self, number: int) -> None:
        """Keeps the signal's `number`."""
        by = "Ctrl-C" if number == signal.SIGINT else signal.Signals(number).name
        super().__init__(f"stopped by {by}")
        self.number = number
        self.exit_code = 128 + number
