"""Limit up to which simulated time may go before the graph must be waited for."""

import math
from collections.abc import Mapping


class Lockstep:
    """The nodes that are waited for, each with the simulated time up to which it has done its work.

    A node is waited for from its first report on. One that is waited for longer than `patience` is given up: it is
    waited for again once it reports again.

    Args:
        lateness: simulated time by which each node may be late, by its name [s].
        others: the same for nodes that are not in `lateness` [s].
        patience: longest wait [s, local time].

    Attributes:
        given_up: the nodes that are not waited for until they report again.
        longest_wait: the longest wait that counted so far [s, local time].
        longest_for: the node that was waited for then; empty before the first wait.
    """

    def __init__(self, lateness: Mapping[str, float], others: float, patience: float) -> None:
        self.given_up: frozenset[str] = frozenset()
        self.longest_wait, self.longest_for = 0.0, ""
        self._lateness = dict(lateness)
        self._others = others
        self._patience = patience
        self._limits: dict[str, float] = {}
        self._waits_since: float | None = None

    def report(self, node: str, until: float) -> bool:
        """Notes that `node` has no work due before the simulated time `until` [s]; inf where it ends.

        Returns:
            Whether the node had been given up.
        """
        was_given_up = node in self.given_up
        self.given_up -= {node}
        self._limits[node] = until + self._lateness.get(node, self._others)
        return was_given_up

    @property
    def limit(self) -> float:
        """Simulated time up to which no node must be waited for [s]; infinite without a node."""
        return min(self._awaited.values(), default=math.inf)

    def goes_on(self) -> None:
        """Notes that simulated time passes."""
        self._waits_since = None

    def waits(self, time: float, now: float, counts: bool = True) -> list[str]:
        """Notes that the simulated time stands still.

        Args:
            time: the simulated time [s].
            now: the local time [s].
            counts: whether the wait counts for `longest_wait`.

        Returns:
            The nodes given up by that.
        """
        if self._waits_since is None:
            self._waits_since = now
        awaited = self._awaited
        wait = now - self._waits_since
        if counts and awaited and wait > self.longest_wait:
            self.longest_wait, self.longest_for = wait, min(awaited, key=awaited.__getitem__)
        if wait <= self._patience:
            return []
        lost = [node for node, limit in awaited.items() if limit <= time or limit == self.limit]
        self.given_up |= set(lost)
        self._waits_since = None
        return lost

    @property
    def _awaited(self) -> dict[str, float]:
        return {node: limit for node, limit in self._limits.items() if node not in self.given_up}
