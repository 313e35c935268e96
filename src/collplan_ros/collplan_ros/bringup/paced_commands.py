"""Commands at a steady pace, from a thread of its own: whatever holds up the main thread makes no gap between them.

In simulated time that waits for them there is no thread.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from threading import Event, Lock, Thread

from collplan_core.command import Command, stopped

ZERO = stopped("check")
LOOK = 0.002
"""Period at which the thread looks at the clock [s]."""
EARLY = 1e-6
"""Sums of decimal times must not decide whether a command is due [s]."""


@dataclass(eq=False)
class PacedMotion:
    """A command that goes on for some time; times are of the clock of its `PacedCommands` [s].

    Attributes:
        begun: time of its first command; until: time at which zero follows it.
        allowed: latest time at which zero follows it, unless that is extended.
        sent: time of its newest command.
        ended: time at which zero followed; inf while it goes on.
        gap: longest time between two commands, the last one being zero.
    """

    command: Command
    begun: float
    until: float
    allowed: float
    sent: float
    ended: float = inf
    gap: float = 0.0

    @property
    def has_lapsed(self) -> bool:
        """True where it ended early because it was no longer allowed."""
        return self.allowed < self.until and self.allowed <= self.ended < inf


class PacedCommands:
    """A context manager: publishes each period the command of the motion under way, zero between motions, and at last.

    A motion ends by itself, also while the thread that began it is stuck, as it is then no longer allowed.
    """

    def __init__(
        self,
        publish: Callable[[Command], None],
        period: float,
        now: Callable[[], float],
        go_on: Callable[[], None] | None = None,
    ) -> None:
        """Functions are called from either thread, never from both at once.

        Args:
            publish: sends a command.
            period: between two commands [s].
            now: the clock [s].
            go_on: takes messages meanwhile, in the thread; without it there is no thread, and the caller calls `look`.
        """
        self._publish, self._now, self._go_on = publish, now, go_on
        self._period = period
        self._due = now()
        self._motion: PacedMotion | None = None
        self._lock = Lock()
        self._leaving = Event()
        self._thread = Thread(target=self._run, name="commands", daemon=True)

    def __enter__(self) -> "PacedCommands":
        if self._go_on is not None:
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        self._leaving.set()
        if self._thread.is_alive():
            self._thread.join()

    def begin(self, command: Command, duration: float, allowed: float) -> PacedMotion:
        """Commands a motion for `duration` [s], but not beyond the time `allowed` [s]."""
        with self._lock:
            now = self._now()
            self._motion = motion = PacedMotion(command, now, now + duration, allowed, now)
            self._send(command)
        return motion

    def allow(self, until: float) -> None:
        """Lets the motion under way go on until this time [s]."""
        with self._lock:
            if self._motion is not None:
                self._motion.allowed = until

    def stop(self) -> None:
        """Commands zero at once."""
        with self._lock:
            self._end()

    def _run(self) -> None:
        while self._go_on is not None and not self._leaving.wait(LOOK):
            try:
                self._go_on()
                self.look()
            except RuntimeError:  # rcl's own errors: the node or its context has ended before
                return

    def look(self) -> None:
        """Sends what is due."""
        with self._lock:
            now, motion = self._now() + EARLY, self._motion
            if motion is not None and now >= min(motion.until, motion.allowed):
                self._end()
            elif now >= self._due:
                self._send(ZERO if motion is None else motion.command)

    def _end(self) -> None:
        motion = self._motion
        before = self._send(ZERO)
        if motion is not None:
            motion.ended, self._motion = before, None

    def _send(self, command: Command) -> float:
        """Publishes a command; returns when it began to."""
        before = self._now()
        self._publish(command)
        after = self._now()
        if self._motion is not None:
            # a thread held up on the way may have published at either end
            self._motion.gap = max(self._motion.gap, after - self._motion.sent)
            self._motion.sent = before
        if before + EARLY >= self._due:
            # by the clock, not by the time since the last one; none is made up for
            self._due = self._due + self._period if self._due + self._period > after else before + self._period
        return before
