"""State of one input of a node over time: it comes, it is missing, or it is refused."""

import re
from collections.abc import Callable

STREAM = "stream"
"""An input that comes all the time: missed when nothing comes."""
STATE = "state"
"""A latched input: missing until it was received, and when no node publishes it any more."""
EVENT = "event"
"""An input that comes when something happens: never missed."""

COMES = "comes"
NOBODY = "0 publishers"
"""Description of an input that no node publishes."""
PATIENCE = 2
"""Checks in a row without a message after which an input is missed. Checks, not seconds: a stalled node misses none."""


class InputWatch:
    """One input, checked at a steady rate: each check reports what has changed since the previous one.

    Args:
        name: name of the topic.
        need: STREAM, STATE or EVENT.
        publishers: describes its publishers: NOBODY, or "1 publisher, ..."; called only where it matters.
        mismatch: describes publishers whose messages can never be received, "" without one.

    Attributes:
        n_taken, n_refused: messages so far.
        hint: what is suspicious about the messages that are taken, "" for nothing.
    """

    def __init__(self, name: str, need: str, publishers: Callable[[], str], mismatch: Callable[[], str]) -> None:
        self.name = name
        self.n_taken = self.n_refused = 0
        self._need = need
        self.hint = ""
        self._publishers = publishers
        self._mismatch = mismatch
        self._reason = ""
        self._checked = 0, 0
        self._quiet = 0
        self._true: dict[str, str] = {}

    def refused(self, reason: str) -> None:
        """Notes a message that was refused for this reason."""
        self.n_refused += 1
        self._reason = reason

    def check(self) -> dict[str, str]:
        """Returns lines about changes since the last check, by the key that makes each a new message.

        The key of an input that arrives is COMES, with its name.
        """
        before, self._true = self._true, self._what_is_true()
        mismatch = self._mismatch()
        # an input that is missing for it has been described with it
        if mismatch and not any(mismatch in text for text in self._true.values()):
            self._true = {**self._true, mismatch: f"{self.name}: {mismatch}"}
        return {fact: text for fact, text in self._true.items() if fact not in before}

    def _what_is_true(self) -> dict[str, str]:
        before, self._checked = self._checked, (self.n_taken, self.n_refused)
        taken, refused = (now - then for now, then in zip(self._checked, before, strict=True))
        stays = not refused and self._need == STATE and self.n_taken > 0 and self._publishers() != NOBODY
        if not (taken or refused or stays):
            return self._without_messages()
        self._quiet = 0
        true = {COMES: self.name} if (taken or stays) and self._need != EVENT else {}
        if refused:
            kind = re.sub(r"\d+", "#", self._reason)  # other numbers in it do not make it another reason
            # that nothing else arrives is a new message, too
            true[f"{bool(taken)} {kind}"] = f"{self.name} refused: {self._reason}"
        if self.hint:
            true["hint"] = f"{self.name}: {self.hint}"
        return true

    def _without_messages(self) -> dict[str, str]:
        self._quiet += 1
        if self._quiet < PATIENCE:
            return self._true
        missing = f"no {self.name}: {self._publishers()}"
        return {} if self._need == EVENT else {missing: missing}
