"""The journals of a run, from the recording of a graph or from the file of a trial."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.replay.reading import Event, events_of, rows_of
from collplan_core.replay.values import JournalError
from collplan_ros.run.reader import messages
from collplan_ros.run.writer import RECORDING

TOPICS = {"planner/journal": PLANNER, "controller/journal": CONTROLLER}


@dataclass(frozen=True, eq=False)
class RecordedJournals:
    """The journals of a run.

    Attributes:
        source: the file that they come from.
        rows: their lines.
    """

    source: Path
    rows: Sequence[Mapping[str, Any]]

    def events(self, of: str) -> list[Event]:
        """Returns the events in the journal of a loop, PLANNER or CONTROLLER; empty where there is none.

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
    rows = rows_of(_lines(path), str(path))
    if not any("of" in row for row in rows):
        raise JournalError(f"{path}: holds no journal, expected a run of bringup or a trial's journal")
    return RecordedJournals(path, rows)


def _lines(path: Path) -> list[str]:
    if path.suffix == ".mcap":
        return [message.data for _, _, message in messages(path, list(TOPICS))]
    try:
        return path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise JournalError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
