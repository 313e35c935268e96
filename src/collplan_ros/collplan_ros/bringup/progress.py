"""What bringup prints: progress of a run, and names in a sentence."""

import math
import os
import sys
import time
from collections.abc import Sequence
from typing import TextIO


def in_words(names: Sequence[str]) -> str:
    """The names as "a, b and c"; at least one."""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


TERMINAL_PERIOD = 0.1
PLAIN_PERIOD = 1.0
ERASE_REST = "\x1b[K"  # takes a terminal's line before, where it was longer, away


class Progress:
    """Prints progress: one line rewritten in place on a terminal, else a plain line a second, if anybody reads it."""

    def __init__(self, stream: TextIO | None = None) -> None:
        """Writes to `stream`, by default to standard output."""
        # Python gives None for a standard output that was closed from the start
        self._stream: TextIO | None = stream or sys.stdout
        self._live = self._stream is not None and self._stream.isatty()
        self._last = 0.0
        self._open = False

    def show(self, elapsed: float, distance: float, maneuver: str, impacts: int, pace: str = "") -> None:
        """Prints time since the first non-zero command [s], distance to the goal [m], maneuver, impacts and pace."""
        if time.monotonic() - self._last < (TERMINAL_PERIOD if self._live else PLAIN_PERIOD):
            return
        self._last = time.monotonic()
        # cut off, not rounded: no time is shown before it has passed
        shown = math.floor(10.0 * elapsed) / 10.0
        line = f"{shown:6.1f} s  {distance:5.2f} m to the goal  {maneuver:<18}  impacts {impacts}"
        line += f", {pace}" if pace else ""
        self._write(f"\r{line}{ERASE_REST}" if self._live else f"{line}\n")
        self._open = self._live

    def say(self, text: str) -> None:
        """Prints a line that later progress does not overwrite; nothing of an empty text."""
        if text:
            self._write(("\n" if self._open else "") + text + "\n")
            self._open = False

    def _write(self, text: str) -> None:
        if self._stream is None:
            return
        try:
            self._stream.write(text)
            self._stream.flush()
        except OSError:  # the pipe, the terminal or the disk behind it is gone, and the run goes on
            # what is left in the stream's buffer must have somewhere to go when the interpreter ends
            with open(os.devnull, "wb") as nowhere:
                os.dup2(nowhere.fileno(), self._stream.fileno())
