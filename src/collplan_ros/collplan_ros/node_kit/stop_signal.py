"""Signals that ask a program to stop, handled at safe points of its loop."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class StopSignal:
    """Keeps the first signal received; rclpy's own handlers end the context before a last message can be sent."""

    def __init__(self) -> None:
        self.number: int | None = None  # of the signal; None before
        self._at_once = False

    def _take(self, number: int, frame: FrameType | None) -> None:
        self.number = self.number or number
        if self._at_once:
            raise KeyboardInterrupt

    @contextmanager
    def at_once(self) -> Iterator[None]:
        """Raises KeyboardInterrupt at a signal until left, or at one that came before: to compile takes minutes."""
        self._at_once = True
        try:
            if self.number is not None:
                raise KeyboardInterrupt
            yield
        finally:
            self._at_once = False

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Handles the signals until left, and restores the old handlers. Without effect outside the main thread."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {number: signal.signal(number, self._take) for number in SIGNALS}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
