"""What there is to say about one input of a node as time goes by: it comes, it is missing, it is refused."""

import re
from collections.abc import Callable
from dataclasses import dataclass

STREAM = "stream"
"""An input that comes all the time: missed when nothing comes."""
STATE = "state"
"""A latched input: missed until it has come, and when nobody publishes it any more."""
AWAITED = "awaited"
"""An input that somebody gives when all else is there: waited for, never missed."""
EVENT = "event"
"""An input that comes when something happens: never missed, never waited for."""

COMES, REFUSED, WAITED_FOR = "comes", "refused", "waited for"
NOBODY = "0 publishers"
"""What is seen of an input that nobody publishes."""
PATIENCE = 2
"""Checks in a row without a message after which an input is missed. Checks, not seconds: a stalled node misses none."""


@dataclass(frozen=True)
class Remark:
    """One thing to say about an input.

    Attributes:
        text: the name of an input that comes; else a whole line.
        comes: whether it is that the input comes.
    """

    text: str
    comes: bool = False


class InputWatch:
    """One input, checked at a steady rate: each check finds something to say where something has changed.

    Args:
        name: name of the topic.
        need: STREAM, STATE, AWAITED or EVENT.
        publishers: says who publishes it, in words: NOBODY, or "1 publisher, ..."; asked only where it matters.

    Attributes:
        n_taken, n_refused: messages so far.
    """

    def __init__(self, name: str, need: str, publishers: Callable[[], str]) -> None:
        self.name = name
        self.need = need
        self.n_taken = 0
        self.n_refused = 0
        self._publishers = publishers
        self._checked = (0, 0)
        self._reason = ""
        self._quiet = 0
        self._state = ""
        self._told = ""

    def took(self) -> None:
        """Notes a message that was taken."""
        self.n_taken += 1

    def refused(self, reason: str) -> None:
        """Notes a message that was refused for this reason."""
        self.n_refused += 1
        self._reason = reason

    @property
    def is_there(self) -> bool:
        """Whether it came when last checked, or is not missed when it does not come."""
        return self._state == COMES or not self._is_missed

    def wait(self) -> None:
        """Notes that it was said to be waited for."""
        self._state = WAITED_FOR

    def check(self) -> list[Remark]:
        """What has changed since the last check and needs a word."""
        before, self._checked = self._checked, (self.n_taken, self.n_refused)
        taken, refused = (now - then for now, then in zip(self._checked, before, strict=True))
        if not taken and not refused and not self._stays():
            return self._without_messages()
        self._quiet = 0
        if not refused:
            self._told = ""
            return self._comes()
        if taken:
            return [*self._comes(), *self._refusal()]
        if self._state != REFUSED:
            self._state, self._told = REFUSED, ""
        return self._refusal()

    @property
    def _is_missed(self) -> bool:
        return self.need in (STREAM, STATE)

    def _stays(self) -> bool:
        """Whether it is there without coming again."""
        return self.need == STATE and self.n_taken > 0 and self._publishers() != NOBODY

    def _comes(self) -> list[Remark]:
        before, self._state = self._state, COMES
        needs_word = self._is_missed or before == WAITED_FOR
        return [Remark(self.name, comes=True)] if needs_word and before != COMES else []

    def _refusal(self) -> list[Remark]:
        kind = re.sub(r"\d+", "#", self._reason)  # other numbers in it do not make it another reason
        if kind == self._told:
            return []
        self._told = kind
        return [Remark(f"{self.name} refused: {self._reason}")]

    def _without_messages(self) -> list[Remark]:
        self._quiet += 1
        if self._quiet < PATIENCE:
            return []
        self._told = ""
        missing = f"no {self.name}: {self._publishers()}" if self._is_missed else ""
        if not missing or self._state == missing:
            return []
        self._state = missing
        return [Remark(missing)]
