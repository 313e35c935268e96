"""Progress of what takes long: a bar on a terminal, a line now and then where nobody watches."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

from tqdm import tqdm

PERIOD = 30.0
"""Time between two lines [s]."""


@contextmanager
def show_progress(total: int, done: int, unit: str, stream: TextIO | None = None) -> Iterator[Callable[[int], object]]:
    """Shows that `done` of `total` are done, of a unit such as "trial", on `stream`, by default standard error.

    Yields:
        What is to be called with the number of those that were done since.
    """
    stream = stream or sys.stderr
    if stream.isatty():
        with tqdm(total=total, initial=done, unit=unit, mininterval=0.5, file=stream) as bar:
            yield bar.update
    else:
        yield _lines(total, done, unit, stream)


def _lines(total: int, done: int, unit: str, stream: TextIO) -> Callable[[int], object]:
    begun = said = time.monotonic()
    count = done

    def update(number: int) -> None:
        nonlocal said, count
        count += number
        now = time.monotonic()
        if now - said >= PERIOD:
            said = now
            print(f"{count} of {total} {unit}s, {count - done} of them in {now - begun:.0f} s", file=stream, flush=True)

    return update
