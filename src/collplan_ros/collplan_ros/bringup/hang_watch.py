"""Ends a callback that does not return, which would otherwise hold up everything in its process."""

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from collplan_ros.bringup.failures import GRAPH_LOST

PATIENCE = 10
"""Looks after which a callback counts as one that does not return; the longest plan takes some tenths of a second."""
LOOK_PERIOD = 1.0
"""Between two looks [s]. Looks are counted, not seconds: after a stop of the whole process there is one."""
SIGNAL = signal.SIGUSR1
"""Interrupts the main thread."""


class Hangs(BaseException):
    """Raised in a callback that does not return. No `Exception`: a callback that handles those must end, too."""


class HangWatch:
    """Watches the callbacks of the main thread. In another thread it does nothing, as signals do not reach that."""

    def __init__(self) -> None:
        self._turn, self._name = 0, ""
        self._overdue = -1
        self._ended = threading.Event()

    def begin(self, name: str) -> None:
        """Notes that a callback of this node begins."""
        self._turn, self._name = self._turn + 1, name

    def end(self) -> None:
        """Notes that it has returned."""
        self._name = ""

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Raises Hangs in a callback that does not return, until left.

        One that does not even get back to Python then, as compiled code may, ends the process.
        """
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = signal.signal(SIGNAL, self._interrupt)
        thread = threading.Thread(target=self._look, name="hang watch", daemon=True)
        thread.start()
        try:
            yield
        finally:
            self._ended.set()
            thread.join()
            signal.signal(SIGNAL, before)

    def _look(self) -> None:
        seen, looks = -1, 0
        while not self._ended.wait(LOOK_PERIOD):
            turn = self._turn
            seen, looks = turn, looks + 1 if self._name and turn == seen else 0
            if looks == PATIENCE:
                self._overdue = turn
                signal.pthread_kill(threading.main_thread().ident or 0, SIGNAL)
            elif looks == 2 * PATIENCE:
                print(f"bringup: {self._name} hangs: its process ends", file=sys.stderr, flush=True)
                os._exit(GRAPH_LOST)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        if self._name and self._turn == self._overdue:
            raise Hangs
