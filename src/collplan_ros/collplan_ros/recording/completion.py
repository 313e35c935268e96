"""Completing what a bringup that was killed has left: its recording, and the result files made from its record.

Who writes a run has its folder locked, and its recording. What is locked is left alone, and so is a recording that
holds nothing yet: it may be locked the moment after.
"""

import fcntl
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from mcap.records import Attachment, Channel, Chunk, DataEnd, Header, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import Writer

from collplan_ros.recording.reading import is_whole
from collplan_ros.recording.recording_file import LIBRARY, RECORDING
from collplan_ros.runs.folder_lock import FolderLock
from collplan_ros.runs.record_reading import RECORD
from collplan_ros.runs.recorded_run import settings_and_world, unfinished
from collplan_ros.runs.result_files import SUMMARY, write_result_files
from collplan_ros.runs.run_error import RunError
from collplan_ros.runs.whole_file import replacing

KILLED, WHY_KILLED = "killed", "bringup ended before the run did"
"""Outcome of a run whose bringup did not live to see another, and its reason."""
NANO = 1e-9


class BeingWritten(RunError):
    """Somebody else writes the run, or is about to."""


def complete(folder: Path, say: Callable[[str], None] = lambda _: None) -> str:
    """Completes the recording of a run whose bringup was killed, and its results; says what was done.

    What it begins to do, which may take long, it tells `say`.

    Of the recording every chunk is kept that was closed and can still be read. What is whole is not changed.

    Raises:
        BeingWritten: it is not left yet.
        RunError: nothing of it can be completed.
        RecordError: a file cannot be written.
    """
    if not folder.is_dir():
        raise RunError(f"{folder}: not a folder, expected one that bringup left")
    if not (folder / RECORDING).exists() and not (folder / RECORD).exists():
        raise RunError(f"{folder}: neither {RECORDING} nor {RECORD}, expected a folder that bringup left")
    done: list[str] = []
    refused: list[str] = []
    with _left(folder):
        say(f"completing {folder} ...")
        # the results need the world that is in the recording
        for completed in (_completed_recording, _completed_results):
            try:
                done += completed(folder)
            except RunError as error:
                refused.append(str(error))
    if refused and not done:
        raise RunError("; ".join(refused))
    return "; ".join([*done, *refused]) or f"{folder}: is whole"


def complete_newest(parent: Path, say: Callable[[str], None] = lambda _: None) -> str:
    """Completes the newest run below `parent` that was killed and can be; says so, or "" where there is none.

    What it begins to do, which may take long, and what it cannot, it tells `say`.

    Raises:
        RecordError: a file cannot be written.
    """
    # `latest` is another name of one of the folders
    folders = [path for path in parent.glob("*") if path.is_dir() and not path.is_symlink()]
    for folder in sorted(filter(_is_unfinished, folders), key=_written_at, reverse=True):
        try:
            return complete(folder, say)
        except BeingWritten:
            continue
        except RunError as error:
            say(str(error))
    return ""


def _is_unfinished(folder: Path) -> bool:
    """Whether results or the end of a recording are missing that could be made."""
    if (folder / RECORD).exists() and not (folder / SUMMARY).exists():
        return True
    with suppress(OSError), (folder / RECORDING).open("rb") as file:
        return not is_whole(file)
    return False


def _written_at(folder: Path) -> float:
    """When something came of a run last [s]."""
    return max(path.stat().st_mtime for name in (RECORD, RECORDING) if (path := folder / name).exists())


@contextmanager
def _left(folder: Path) -> Iterator[None]:
    """Locks a folder and its recording.

    Raises:
        BeingWritten: somebody else has, or is about to.
        RunError: it cannot be locked.
    """
    being_written = BeingWritten(f"{folder}: is being written, and left as it is")
    with ExitStack() as stack:
        try:
            stack.enter_context(closing(FolderLock(folder)))
            if (folder / RECORDING).exists():
                file = stack.enter_context((folder / RECORDING).open("rb"))
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if file.seek(0, 2) == 0:
                    raise being_written
        except BlockingIOError:
            raise being_written from None
        except OSError as error:
            raise RunError(f"{error.filename or folder}: cannot be locked: {error.strerror or error}") from None
        yield


def _completed_recording(folder: Path) -> Iterator[str]:
    """Puts a recording with an end in the place of one without; says so.

    Raises:
        RunError: it is none.
    """
    path = folder / RECORDING
    if not path.exists():
        return
    with path.open("rb") as file:
        if is_whole(file):
            return
        kept = _rewritten(file, path)
    if not kept:
        raise RunError(f"{path}: begins as no recording does, and is left as it is")
    yield f"{path}: had no end; {kept}"


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
    """Makes the result files from the record, where there is one and they are not; says so.

    Raises:
        RunError: they cannot be made.
    """
    record = unfinished(folder)
    if record is None:
        return
    try:
        settings, world = settings_and_world(folder)
    except RunError as error:
        raise RunError(f"{folder / SUMMARY} cannot be made: {error}") from None
    if not np.isfinite(record.goal).all():
        raise RunError(f"{folder / SUMMARY} cannot be made: the run had not begun")
    write_result_files(
        folder, record.log, world, record.goal, settings, KILLED, record.simulated, {"reason": WHY_KILLED}
    )
    yield f"{folder / SUMMARY} and what goes with it are made from {RECORD}"
