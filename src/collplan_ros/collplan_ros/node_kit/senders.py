"""Whether the messages of a topic come from one publisher, by the count that each publisher keeps of its own."""

WINDOW = 10.0
"""Time for which a count is remembered [s]: a second publisher may be slow."""
MOST_RETURNS = 3
"""Returns to an earlier count within WINDOW that show two publishers. One that has started again never returns."""


class Senders:
    """Follows the counts of a topic's publishers; an idle publisher, or one that has started again, is no second."""

    def __init__(self) -> None:
        self._counts: list[tuple[int, float]] = []
        self._returns: list[float] = []

    def took(self, number: int | None, now: float) -> None:
        """Notes a message by its publisher's count, None where the middleware gives none, at `now` [s, steady]."""
        if number is None:
            return
        self._counts = [each for each in self._counts if now - each[1] < WINDOW]
        own = max((each for each in self._counts if each[0] < number), default=None)
        if own is not None:
            if own is not self._counts[-1]:
                self._returns.append(now)
            self._counts.remove(own)
        self._counts.append((number, now))

    def are_several(self, now: float) -> bool:
        """Returns whether at least two of them send at `now` [s]."""
        self._returns = [each for each in self._returns if now - each < WINDOW]
        return len(self._returns) >= MOST_RETURNS
