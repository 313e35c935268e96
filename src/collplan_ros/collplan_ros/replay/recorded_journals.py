"""The journals of a run, from the recording of a graph or from the file of a trial."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from collplan_core.replay.journal import CONTROLLER, PLANNER
from collplan_core.replay.reading import Event, events_of, rows_of
from collplan_core.replay.values import JournalError
from collplan_ros.messages.reading import NANOSECONDS
from collplan_ros.run.reader import is_whole, messages
from collplan_ros.run.writer import RECORDING

TOPICS = {"planner/journal": PLANNER, "controller/journal": CONTROLLER}


@dataclass(frozen=True, eq=False)
class RecordedJournals:
    """The journals of a run."""

    rows: Sequence[Mapping[str, Any]]  # their lines
    cut: str = ""  # where that file is cut off, in words; "" where it has an end

    def events(self, of: str) -> list[Event]:
        """The events of a loop, PLANNER or CONTROLLER, empty where there is none.

        JournalError: a line does not hold what a journal does.
        """
        return list(events_of(self.rows, of))


def read_journals(run: Path) -> RecordedJournals:
    """The journals of a run folder, a recording, or a file that a trial has written.

    JournalError: there is none, or it cannot be read. RunError: a recording that cannot be read.
    """
    path = run / RECORDING if run.is_dir() else run
    lines, cut = _recorded_lines(path) if path.suffix == ".mcap" else _written_lines(path)
    rows = rows_of(lines, str(path))
    if not any("of" in row for row in rows):
        raise JournalError(f"{path}: holds no journal, expected a run of bringup or a trial's journal")
    return RecordedJournals(rows, cut)


def _recorded_lines(path: Path) -> tuple[list[str], str]:
    found = list(messages(path, list(TOPICS)))
    duration = (found[-1][1] - found[0][1]) / NANOSECONDS if found else 0.0
    cut = "" if is_whole(path) else f"{path}: has no end, it is cut off after {duration:.1f} s"
    return [message.data for _, _, message in found], cut


def _written_lines(path: Path) -> tuple[list[str], str]:
    try:
        text = path.read_text(encoding="utf-8")
        return text.splitlines(), "" if text.endswith("\n") else f"{path}: has no end, its last line is cut off"
    except (OSError, UnicodeDecodeError) as error:
        raise JournalError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
