"""Counts of refused inputs, for a node's diagnostics."""

from collections import Counter


class Refusals:
    """Refused inputs: counts by kind, and the newest reason.

    Attributes:
        newest: reason of the newest refusal; empty before the first.
    """

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self.newest = ""

    def add(self, kind: str, reason: str) -> None:
        """Counts an input of this kind that was refused for this reason."""
        self._counts[kind] += 1
        self.newest = reason

    def __getitem__(self, kind: str) -> int:
        return self._counts[kind]

    @property
    def values(self) -> dict[str, object]:
        """Values of a `Health`: `refused_<kind>` and `last_refusal`; empty before the first refusal."""
        counts: dict[str, object] = {f"refused_{kind}": count for kind, count in sorted(self._counts.items())}
        return {**counts, "last_refusal": self.newest} if counts else {}
