"""Signals that ask bringup to stop, handled at safe points of its loop."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from collplan_ros.bringup.failures import Interrupted

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class StopRequest:
    """Holds the first signal received, until `check()` raises it as an exception."""

    def __init__(self) -> None:
        self._number: int | None = None

    def check(self) -> None:
        """Raises Interrupted if a signal was received."""
        if self._number is not None:
            raise Interrupted(self._number)

    def _take(self, number: int, frame: FrameType | None) -> None:
        self._number = self._number or number

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
