"""What a node refused, for its diagnostics."""

from collections import Counter


class Refusals:
    """Counts by kind, and the newest reason in words."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self.newest = ""

    def add(self, kind: str, reason: str) -> None:
        """Something of this kind was refused for that reason."""
        self._counts[kind] += 1
        self.newest = reason

    def __getitem__(self, kind: str) -> int:
        return self._counts[kind]

    @property
    def values(self) -> dict[str, object]:
        """Ready for a `Health`: `refused_<kind>` and `last_refusal`."""
        counts: dict[str, object] = {f"refused_{kind}": count for kind, count in sorted(self._counts.items())}
        return {**counts, "last_refusal": self.newest} if counts else {}
