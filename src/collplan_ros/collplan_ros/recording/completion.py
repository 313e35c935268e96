"""Completing what a bringup that was killed has left: its recording, and the result files made from its record.

Who writes a recording has it locked. One that is locked is left alone, and so is one that holds nothing yet: it may be
locked the moment after.
"""

import fcntl
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from mcap.records import Attachment, Channel, Chunk, DataEnd, Header, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import Writer

from collplan_core.parameters import Settings
from collplan_core.parameters.file import read_parameters
from collplan_core.worlds import load_world
from collplan_ros.recording.reading import is_whole
from collplan_ros.recording.recording_file import LIBRARY, RECORDING
from collplan_ros.runs.record_reading import RECORD, read_record
from collplan_ros.runs.result_files import SUMMARY, write_result_files
from collplan_ros.runs.whole_file import replacing

KILLED = "killed"
"""Outcome of a run whose bringup did not live to see another."""
NANO = 1e-9


def complete(folder: Path) -> str:
    """Completes the recording of a run whose bringup was killed, and its folder; says what was done.

    Of the recording every chunk is kept that was closed and can still be read. Nothing is changed while it is being
    written, nor where it is whole.

    Raises:
        RecordError: a file cannot be written.
    """
    path = folder / RECORDING
    try:
        opened = path.open("rb")
    except OSError as error:
        return f"{path}: cannot be read: {error.strerror or error}"
    with opened as file:
        if not _is_left(file):
            return f"{path}: is being written, and left as it is"
        if is_whole(file):
            return f"{path}: is whole"
        kept = _rewritten(file, path)
        if not kept:
            return f"{path}: begins as no recording does, and is left as it is"
        return "; ".join((f"{path}: had no end; {kept}", *_completed_results(folder)))


def complete_newest(parent: Path) -> str:
    """Completes the newest run below `parent` whose bringup was killed; says so, or "" where there is none.

    Raises:
        RecordError: a file cannot be written.
    """
    for path in sorted(_recordings(parent), key=lambda path: path.stat().st_mtime, reverse=True):
        unfinished = False
        with suppress(OSError), path.open("rb") as file:
            unfinished = _is_left(file) and not is_whole(file)
        if unfinished:
            return complete(path.parent)
    return ""


def _recordings(parent: Path) -> Iterator[Path]:
    # `latest` is another name of one of the folders
    return (path for path in parent.glob(f"*/{RECORDING}") if not path.parent.is_symlink())


def _is_left(file: BinaryIO) -> bool:
    """Locks a file until it is closed; whether it holds something and nobody else has it locked."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return file.seek(0, 2) > 0


def _rewritten(file: BinaryIO, path: Path) -> str:
    """Puts a file with an end and all that is left of `file` in its place; says what it holds."""
    records = _records(file)
    header = next(records, None)
    if not isinstance(header, Header):
        return ""
    with replacing(path) as new, new.open("wb") as target:
        copy = _Copy(target, header)
        for record in records:
            copy.take(record)
        copy.finish()
    return copy.said


def _records(file: BinaryIO) -> Iterator[McapRecord]:
    """The records up to where the file is cut off; those of a chunk come before it, one by one.

    What is not protected by the chunk around it is taken where nothing else could be: header, attachments, metadata.
    """
    reader = StreamReader(file, emit_chunks=True, record_size_limit=file.seek(0, 2)).records
    file.seek(0)
    while True:
        try:
            record = next(reader, None)
        except OSError:
            raise
        except Exception:  # whatever the library makes of half a record, or of what is none
            return
        if record is None or isinstance(record, DataEnd):
            return
        if isinstance(record, Chunk):
            yield from _whole_chunk(record)
        if isinstance(record, Header | Attachment | Metadata | Chunk):
            yield record


def _whole_chunk(chunk: Chunk) -> list[McapRecord]:
    """The records of a chunk; none where the disk has changed it, as the next chunk may be as it was."""
    try:
        return breakup_chunk(chunk, validate_crc=True)
    except Exception:  # of a library that takes it for what was written
        return []


class _Copy:
    """Writes records anew, a chunk as a chunk."""

    def __init__(self, target: Any, header: Header) -> None:
        self._writer = Writer(target)
        self._writer.start(profile=header.profile, library=LIBRARY)
        self._schemas = {0: 0}
        self._channels: dict[int, int] = {}
        self._count = self._first = self._last = 0

    @property
    def said(self) -> str:
        """What was written, in words."""
        return f"completed, it holds {self._count} messages of {NANO * (self._last - self._first):.1f} s"

    def take(self, record: McapRecord) -> None:
        """Writes a record that is no index."""
        if isinstance(record, Schema):
            self._schemas[record.id] = self._writer.register_schema(record.name, record.encoding, record.data)
        elif isinstance(record, Channel) and record.schema_id in self._schemas:
            schema, about = self._schemas[record.schema_id], (record.topic, record.message_encoding)
            self._channels[record.id] = self._writer.register_channel(*about, schema, record.metadata)
        elif isinstance(record, Message) and record.channel_id in self._channels:
            self._take_message(record)
        elif isinstance(record, Attachment):
            times, kind = (record.create_time, record.log_time), (record.name, record.media_type)
            self._writer.add_attachment(*times, *kind, record.data)
        elif isinstance(record, Metadata):
            self._writer.add_metadata(record.name, record.metadata)
        elif isinstance(record, Chunk):
            self._writer.flush()

    def finish(self) -> None:
        """Writes index and end."""
        self._writer.finish()

    def _take_message(self, message: Message) -> None:
        channel, came = self._channels[message.channel_id], message.log_time
        self._writer.add_message(channel, came, message.data, message.publish_time, message.sequence)
        self._first = min(self._first, came) if self._count else came
        self._last = max(self._last, came)
        self._count += 1


def _completed_results(folder: Path) -> Iterator[str]:
    """Makes the result files from the record, where there is one and they are not; says what was done or why not."""
    if (folder / SUMMARY).exists() or not (folder / RECORD).exists():
        return
    try:
        record = read_record(folder / RECORD)
        settings = Settings().with_values(read_parameters(folder / "parameters.yaml"))
        world = load_world(settings.simulator.world)
    except (OSError, LookupError, TypeError, ValueError) as error:
        yield f"{SUMMARY} cannot be made: {error}"
        return
    if not np.isfinite(record.goal).all():
        yield "the run had not begun"
        return
    write_result_files(folder, record.log, world, record.goal, settings, KILLED, record.simulated, {})
    yield f"{SUMMARY} and what goes with it are made from {RECORD}"
