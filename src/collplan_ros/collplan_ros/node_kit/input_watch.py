"""State of one input of a node over time: it comes, it is missing, or it is refused."""

import math
import re
from collections import Counter
from collections.abc import Callable

STREAM = "stream"
"""An input that comes all the time: missed when nothing comes."""
STATE = "state"
"""A latched input: missing until it was received, and when no node publishes it any more."""
EVENT = "event"
"""An input that comes when something happens: never missed."""

COMES = "comes"
CONFLICT = "conflict"
"""Keys of lines that are no warnings."""
QUIET_CHECKS = 2
"""Checks in a row without a message after which an input is missed. Checks, not seconds: a stalled node misses none."""


class InputWatch:
    """One input, checked at a steady rate: each check reports what has changed since the previous one.

    `need` is STREAM, STATE or EVENT; `publishers` returns for each why its messages can never be received, or "".
    """

    def __init__(self, name: str, need: str, publishers: Callable[[], list[str]]) -> None:
        self.name = name
        self.n_taken = self.n_refused = 0  # messages so far
        self.taken_at = -math.inf  # local time of the newest one taken [s]
        self._need = need
        self.hint = self.dropped = self.conflict = ""
        """What is suspicious of messages taken; why the newest was neither taken nor refused; which contradict each
        other or the settings, and what to do; else empty."""
        self._publishers = publishers
        self._reason = ""
        self._checked = 0, 0
        self._quiet = 0
        self._true: dict[str, str] = {}

    def refused(self, reason: str) -> None:
        """Notes a message that was refused for this reason."""
        self.n_refused += 1
        self._reason = reason

    def check(self) -> dict[str, str]:
        """Lines about changes since the last check, by the key that makes each a new message.

        The key of an input that arrives is COMES, with its name.
        """
        before, self._true = self._true, self._what_is_true()
        # an obstacle told while the input was missing is not told again once it comes from another publisher
        return {fact: text for fact, text in self._true.items() if fact not in before and f"no {fact}" not in before}

    def _what_is_true(self) -> dict[str, str]:
        before, self._checked = self._checked, (self.n_taken, self.n_refused)
        taken, refused = (now - then for now, then in zip(self._checked, before, strict=True))
        publishers = self._publishers()
        stays = not refused and self._need == STATE and self.n_taken > 0 and "" in publishers
        self._quiet = 0 if taken or refused or stays else self._quiet + 1
        if 0 < self._quiet < QUIET_CHECKS:
            return self._true
        true = {COMES: self.name} if (taken or stays) and self._need != EVENT else {}
        if refused:
            kind = re.sub(r"\d+", "#", self._reason)  # other numbers in it do not make it another reason
            # that nothing else arrives is a new message, too
            true[f"{bool(taken)} {kind}"] = f"{self.name} refused: {self._reason}"
        if self.hint:
            true["hint"] = f"{self.name}: {self.hint}"
        if self.conflict:
            true[CONFLICT] = self.conflict
        return true | {line: line for line in self._obstacles(publishers)}

    def _obstacles(self, publishers: list[str]) -> list[str]:
        """Lines about the lack of messages, and about publishers whose messages can never be received."""
        missing = self._quiet > 0 and self._need != EVENT
        silence = (self.dropped if self._quiet else "") or "nothing received" * missing
        reasons = Counter(why or silence for why in publishers)
        found = [f"{counted(n)}, {why}" for why, n in reasons.items() if why]
        if missing and not publishers:
            found = [counted(0)]
        return [f"{'no ' if missing else ''}{self.name}: {each}" for each in found]


def counted(n: int) -> str:
    """A number of publishers in words."""
    return f"{n} publisher{'s' * (n != 1)}"
