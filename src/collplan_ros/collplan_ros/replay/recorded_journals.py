"""The journals of a run, from the recording of a graph or from the file of a trial."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from collplan_core.parameters import Settings
from collplan_core.replay.contents import Contents
from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.replay.reading import Beginning, Event, contents_of, events_of, rows_of
from collplan_core.replay.values import JournalError
from collplan_core.scan import ScanError
from collplan_ros.messages.reading import MessageError, plan_from_path, scan_from_message
from collplan_ros.run.reader import messages
from collplan_ros.run.writer import RECORDING

TOPICS = {"planner/journal": PLANNER, "controller/journal": CONTROLLER}
CONTENTS = ("scan", "plan")
Messages = Callable[[Path, Sequence[str]], Iterator[tuple[str, int, Any]]]
"""The messages of some topics of a recording: topic, when it came [ns], and the message."""


@dataclass(frozen=True, eq=False)
class RecordedJournals:
    """The journals of a run.

    Attributes:
        source: the file that they come from.
        rows: their lines.
        contents: the scans and plans that they refer to.
    """

    source: Path
    rows: Sequence[Mapping[str, Any]]
    contents: Contents

    def events(self, of: str) -> list[Event]:
        """What stands in the journal of a loop, PLANNER or CONTROLLER; nothing where there is none.

        Raises:
            JournalError: a line does not hold what a journal does.
        """
        return list(events_of(self.rows, of))


def read_journals(run: Path) -> RecordedJournals:
    """The journals of a run folder, a recording, or a file that a trial has written.

    Raises:
        JournalError: there is none, or it cannot be read.
        RunError: a recording that cannot be read.
    """
    path = run / RECORDING if run.is_dir() else run
    found = journals_from_recording(path, messages) if path.suffix == ".mcap" else _from_file(path)
    if not any("of" in row for row in found.rows):
        raise JournalError(f"{path}: holds no journal, expected a run of bringup or a trial's journal")
    return found


def _from_file(path: Path) -> RecordedJournals:
    try:
        with path.open(encoding="utf-8") as file:
            rows = rows_of(file, str(path))
    except (OSError, UnicodeDecodeError) as error:
        raise JournalError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    return RecordedJournals(path, rows, contents_of(rows))


def journals_from_recording(path: Path, read: Messages) -> RecordedJournals:
    """The journals in a recording, whose messages are got by `read`.

    Raises:
        JournalError: a line cannot be read.
        RunError: the recording cannot be read.
    """
    lines: list[str] = []
    recorded: list[tuple[str, Any]] = []
    for topic, _, message in read(path, [*TOPICS, *CONTENTS]):
        if topic in TOPICS:
            lines.append(message.data)
        else:
            recorded.append((topic, message))
    rows = rows_of(lines, str(path))
    contents = contents_of(rows)
    settings = _settings(rows)
    frames = settings.frames
    for topic, message in recorded:
        # what is no scan and no plan was not taken either
        with suppress(ScanError, MessageError):
            if topic == "scan":
                contents.add(scan_from_message(message, frames.base, settings.scan))
            else:
                contents.add(plan_from_path(message, frames.map))
    return RecordedJournals(path, rows, contents)


def _settings(rows: Sequence[Mapping[str, Any]]) -> Settings:
    """What the nodes were given at first."""
    for of in TOPICS.values():
        for event in events_of(rows, of):
            if isinstance(event, Beginning):
                return event.settings
    return Settings()
