"""Completion of a run whose bringup was killed: the end of its recording, and its results.

A run that is being written has its folder locked; a locked folder is left unchanged.
"""

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.records import Attachment, Channel, Chunk, Header, McapRecord, Message, Metadata, Schema
from mcap.writer import Writer

from collplan_ros.run.description import BEGIN, PARAMETERS
from collplan_ros.run.reader import attachment, description, is_whole, records
from collplan_ros.run.recorded_run import NANO, read_run
from collplan_ros.run.result_files import IMPACTS, SUMMARY, TRAJECTORY, write_result_files
from collplan_ros.run.whole_file import FolderLock, RunError, has_end, replacing
from collplan_ros.run.writer import LIBRARY, RECORDING

KILLED, WHY_KILLED = "killed", "bringup ended before the run did"
"""Outcome of a run whose bringup did not live to see another, and its reason."""


class BeingWritten(RunError):
    """Error of a run that another process is writing."""


def complete(folder: Path, say: Callable[[str], None] = lambda _: None) -> str:
    """Completes the recording of a run whose bringup was killed, and its results; returns a report.

    It announces to `say` a task that may take long. Every chunk of the recording that was closed and can still be
    read is kept. Complete files are not changed.

    Raises:
        BeingWritten: another process is still writing it.
        RunError: it cannot be completed.
        RecordError: a file cannot be written.
    """
    if not folder.is_dir():
        raise RunError(f"{folder}: not a folder, expected one that bringup left")
    path = folder / RECORDING
    if not path.exists():
        raise RunError(f"{folder}: no {RECORDING}, expected a folder that bringup left")
    with _left(folder):
        say(f"completing {folder} ...")
        done = [] if is_whole(path) else [f"{path}: had no end; {_rewritten(path)}"]
        if not has_end(folder / SUMMARY):
            try:
                done.append(_results(folder))
            except RunError as error:
                if not done:
                    raise
                done.append(str(error))
        if (folder / PARAMETERS).exists() and not has_end(folder / PARAMETERS):
            with replacing(folder / PARAMETERS) as unfinished:
                unfinished.write_text(attachment(path, PARAMETERS), encoding="utf-8")
            done.append(f"{folder / PARAMETERS} is made from {RECORDING}")
        cut = [name for name in (TRAJECTORY, IMPACTS) if not has_end(folder / name)]
        if cut and has_end(folder / SUMMARY):
            done.append(f"{folder}: {' and '.join(cut)} cut off: remove {SUMMARY}, and the results are made anew")
    return "; ".join(done) or f"{folder}: is whole"


def complete_newest(parent: Path, say: Callable[[str], None] = lambda _: None) -> str:
    """Completes the newest run below `parent` that was killed and can be; returns a report, or "" without one.

    It announces to `say` a task that may take long, and a failure.

    Raises:
        RecordError: a file cannot be written.
    """
    # `latest` is another name of one of the folders
    folders = [path for path in parent.glob("*") if (path / RECORDING).exists() and not path.is_symlink()]
    newest_first = sorted(folders, key=lambda folder: (folder / RECORDING).stat().st_mtime, reverse=True)
    for folder in filter(_is_unfinished, newest_first):
        try:
            return complete(folder, say)
        except BeingWritten:
            continue
        except RunError as error:
            say(str(error))
    return ""


def _is_unfinished(folder: Path) -> bool:
    """Returns whether the end of a recording is missing, or the results of a run that had begun."""
    path = folder / RECORDING
    with suppress(RunError):
        return not is_whole(path) or (not has_end(folder / SUMMARY) and bool(description(path, BEGIN)))
    return False


@contextmanager
def _left(folder: Path) -> Iterator[None]:
    """Locks a folder.

    Raises:
        BeingWritten: another process has locked it.
        RunError: it cannot be locked.
    """
    try:
        lock = FolderLock(folder)
    except BlockingIOError:
        raise BeingWritten(f"{folder}: is being written, and is left unchanged") from None
    except OSError as error:
        raise RunError(f"{folder}: cannot be locked: {error.strerror or error}") from None
    with closing(lock):
        yield


def _rewritten(path: Path) -> str:
    """Replaces a recording by one with an end and all that can be read of it; returns a report of its content.

    Raises:
        RunError: it is no recording.
    """
    with path.open("rb") as file, replacing(path) as new, new.open("wb") as target:
        return _copied(records(file), path, target)


def _copied(found: Iterator[McapRecord], path: Path, target: BinaryIO) -> str:
    header = next(found, None)
    if not isinstance(header, Header):
        raise RunError(f"{path}: does not begin like a recording, and is left unchanged")
    schemas, channels, times = {0: 0}, dict[int, int](), list[int]()
    writer = Writer(target)
    writer.start(profile=header.profile, library=LIBRARY)
    for record in found:
        if isinstance(record, Schema):
            schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
        elif isinstance(record, Channel) and record.schema_id in schemas:
            about = record.topic, record.message_encoding, schemas[record.schema_id]
            channels[record.id] = writer.register_channel(*about, record.metadata)
        elif isinstance(record, Message) and record.channel_id in channels:
            sent, number = record.publish_time, record.sequence
            writer.add_message(channels[record.channel_id], record.log_time, record.data, sent, number)
            times.append(record.log_time)
        elif isinstance(record, Attachment):
            made, kind = (record.create_time, record.log_time), (record.name, record.media_type)
            writer.add_attachment(*made, *kind, record.data)
        elif isinstance(record, Metadata):
            writer.add_metadata(record.name, record.metadata)
        elif isinstance(record, Chunk):
            writer.flush()
    writer.finish()
    duration = (max(times) - times[0]) / NANO if times else 0.0
    return f"completed, it holds {len(times)} messages of {duration:.1f} s"


def _results(folder: Path) -> str:
    """Makes the result files of a run from its recording; returns a report.

    Raises:
        RunError: they cannot be made.
    """
    try:
        run = read_run(folder)
    except RunError as error:
        raise RunError(f"{folder / SUMMARY} cannot be made: {error}") from None
    if not np.isfinite(run.log.goal).all():
        raise RunError(f"{folder / SUMMARY} cannot be made: the run had not begun")
    write_result_files(folder, run.log, run.world, run.log.goal, run.settings, KILLED, {"reason": WHY_KILLED})
    return f"{folder / SUMMARY} and the other results are made from {RECORDING}"
