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

COMES = "comes"
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
    """One input, checked at a steady rate: each check says what is true of it and was not at the check before.

    Args:
        name: name of the topic.
        need: STREAM, STATE, AWAITED or EVENT.
        publishers: says who publishes it, in words: NOBODY, or "1 publisher, ..."; asked only where it matters.

    Attributes:
        n_taken, n_refused: messages so far.
        reason: why the newest refused message was.
        is_waited_for: whether it was said to be.
    """

    def __init__(self, name: str, need: str, publishers: Callable[[], str]) -> None:
        self.name = name
        self.need = need
        self.n_taken = self.n_refused = 0
        self.reason = ""
        self.is_waited_for = False
        self._publishers = publishers
        self._is_missed = need in (STREAM, STATE)
        self._checked = 0, 0
        self._quiet = 0
        self._true: dict[str, Remark] = {}

    def refused(self, reason: str) -> None:
        """Notes a message that was refused for this reason."""
        self.n_refused += 1
        self.reason = reason

    @property
    def is_there(self) -> bool:
        """Whether it came when last checked, or is not missed when it does not come."""
        return COMES in self._true or not self._is_missed

    def check(self) -> list[Remark]:
        """What has changed since the last check and needs a word."""
        before, self._true = self._true, self._what_is_true()
        return [remark for fact, remark in self._true.items() if fact not in before and remark.text]

    def _what_is_true(self) -> dict[str, Remark]:
        """What there is to say now, by what makes it another thing to say; without text where it needs no word."""
        before, self._checked = self._checked, (self.n_taken, self.n_refused)
        taken, refused = (now - then for now, then in zip(self._checked, before, strict=True))
        stays = not refused and self.need == STATE and self.n_taken > 0 and self._publishers() != NOBODY
        if not (taken or refused or stays):
            return self._without_messages()
        self._quiet = 0
        true = {}
        if taken or stays:
            true[COMES] = Remark(self.name if self._is_missed or self.is_waited_for else "", comes=True)
            self.is_waited_for = False
        if refused:
            kind = re.sub(r"\d+", "#", self.reason)  # other numbers in it do not make it another reason
            # that nothing else comes is another thing, too
            true[f"{bool(taken)} {kind}"] = Remark(f"{self.name} refused: {self.reason}")
        return true

    def _without_messages(self) -> dict[str, Remark]:
        self._quiet += 1
        if self._quiet < PATIENCE:
            return self._true
        missing = f"no {self.name}: {self._publishers()}" if self._is_missed else ""
        return {missing: Remark(missing)}
