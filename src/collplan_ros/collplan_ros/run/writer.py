"""run.mcap while it is written: what was flushed survives the end of this process, whatever ends it."""

import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import IO, cast

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import LIBRARY_IDENTIFIER, Writer

from collplan_ros.run.whole_file import RecordError

RECORDING = "run.mcap"
LIBRARY = f"collplan, {LIBRARY_IDENTIFIER}"
FLUSH_PERIOD = 0.5
"""Longest time for which messages are kept in memory [s]."""


class _Pending:
    """Bytes not yet in the file: one of Python's keeps those that a full disk refused, and tries again when closed."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._count = 0

    def write(self, data: bytes) -> int:
        self._parts.append(data)
        self._count += len(data)
        return len(data)

    def tell(self) -> int:
        return self._count

    def flush(self) -> None:
        pass

    def taken(self) -> bytes:
        parts, self._parts = self._parts, []
        return b"".join(parts)


class RecordingFile:
    """A file in the MCAP format; after a failure nothing more is written.

    RecordError: the file cannot be written; on construction, and from `flush_when_due`, `flush` and `finish` the first
    time that this is noticed.
    """

    def __init__(self, path: Path) -> None:
        """Makes the file, which must not exist."""
        self._path = path
        self._pending = _Pending()
        self._flushed = time.monotonic()
        self._failed = False
        self._schemas: dict[str, int] = {}
        try:
            self._descriptor: int | None = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
        except OSError as error:
            raise RecordError(path, error) from None
        self._writer = Writer(cast(IO[bytes], self._pending))
        self._writer.start(profile=Profile.ROS2, library=LIBRARY)

    def attach(self, name: str, media_type: str, text: str) -> None:
        """Adds a file of the run."""
        now = time.time_ns()
        self._writer.add_attachment(now, now, name, media_type, text.encode())

    def describe(self, name: str, values: Mapping[str, str]) -> None:
        """Adds values by name, under the name of their subject; after the messages taken until now."""
        self._writer.flush()
        self._writer.add_metadata(name, dict(values))

    def channel(self, topic: str, kind: str, definition: str | None, about: Mapping[str, str]) -> int:
        """Adds a topic by its full name; returns the channel that its messages are written by.

        `kind` is their type, such as nav_msgs/msg/Odometry, `definition` that of it as text, None where unknown.
        """
        if kind not in self._schemas:
            encoding = SchemaEncoding.SelfDescribing if definition is None else SchemaEncoding.ROS2
            self._schemas[kind] = self._writer.register_schema(kind, encoding, (definition or "").encode())
        return self._writer.register_channel(topic, MessageEncoding.CDR, self._schemas[kind], dict(about))

    def write(self, channel: int, data: bytes, came: int, sent: int, number: int) -> None:
        """Takes a message, CDR with its header, that was sent and came then [ns, wall clock]; the next flush writes it.

        `number` is its number among its publisher's messages, 0 where that is unknown.
        """
        if not self._failed:
            self._writer.add_message(channel, came, data, sent, number & 0xFFFFFFFF)

    def flush_when_due(self) -> None:
        """Flushes, FLUSH_PERIOD after the last time."""
        if time.monotonic() - self._flushed >= FLUSH_PERIOD:
            self.flush()

    def flush(self) -> None:
        """Closes the chunk of messages that is open and hands it to the operating system."""
        self._flushed = time.monotonic()
        if not self._failed:
            self._writer.flush()
            self._hand_on()

    def finish(self) -> None:
        """Writes index and end, and closes the file."""
        if self._descriptor is None:
            return
        try:
            if not self._failed:
                self._writer.finish()
                self._hand_on()
        finally:
            os.close(self._descriptor)
            self._descriptor, self._failed = None, True

    def _hand_on(self) -> None:
        rest = memoryview(self._pending.taken())
        try:
            while rest and self._descriptor is not None:
                rest = rest[os.write(self._descriptor, rest) :]
        except OSError as error:
            self._failed = True
            raise RecordError(self._path, error) from None
