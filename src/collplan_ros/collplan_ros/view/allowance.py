"""How much of something may come in a time: a little at once, and a rate that fills it up again."""


class Allowance:
    """What is left of an amount that grows by `rate` a second up to `most`."""

    def __init__(self, most: float, rate: float) -> None:
        self._left = self._most = most
        self._rate = rate
        self._at: float | None = None

    def spend(self, amount: float, now: float) -> bool:
        """Takes an amount at `now` [s, steady]; whether there was as much."""
        since = 0.0 if self._at is None else max(0.0, now - self._at)
        self._at = now
        self._left = min(self._most, self._left + self._rate * since) - amount
        return self._left >= 0.0
