"""Reading of a journal: its beginning, each call, and missing lines."""

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from collplan_core.parameters import Settings
from collplan_core.parameters.spec import ParameterError
from collplan_core.replay.journal import FORMAT
from collplan_core.replay.values import JournalError, decode


@dataclass(frozen=True)
class Beginning:
    """The start of a loop."""

    settings: Settings  # settings that it is made with
    known_map: str | None  # text of the world file given to the planner; None where it is given none
    made_with: Mapping[str, str]  # code and machine, by name


@dataclass(frozen=True)
class Call:
    """A call of the loop."""

    name: str  # name of the method
    args: tuple[Any, ...]  # its arguments
    forbidden: tuple[str, ...] = ()  # answers to its queries why it is forbidden to act; empty where it never was
    deadline_checks: tuple[int | None, ...] = ()
    """Number of looks at each deadline before that passed; None where it did not pass."""
    result: Any = None  # the outcome, as JSON


@dataclass(frozen=True)
class Gap:
    """Gap in a journal: the number of a line that is not the one expected."""

    number: int
    due: int

    def __str__(self) -> str:
        missing = self.number - self.due
        if missing < 0:
            return f"line {self.number} comes where line {self.due} was due"
        lines = "1 line is" if missing == 1 else f"{missing} lines are"
        return f"{lines} missing before line {self.number} of the journal"


Event = Beginning | Call | Gap


def rows_of(lines: Iterable[str], source: str) -> list[dict[str, Any]]:
    """The lines of a journal, or of several in one file, as objects. A last one that was cut off is left out.

    Raises:
        JournalError: one is no JSON object; `source` stands in the message.
    """
    rows: list[dict[str, Any]] = []
    broken = ""
    for number, line in enumerate(lines, start=1):
        if broken:
            raise JournalError(broken)
        try:
            row = json.loads(line)
        except ValueError as error:
            broken = f"{source}: line {number}: not JSON: {error}"
            continue
        if not isinstance(row, dict):
            raise JournalError(f"{source}: line {number}: got {line.strip():.40}, expected an object")
        rows.append(row)
    return rows


def events_of(rows: Iterable[Mapping[str, Any]], of: str) -> Iterator[Event]:
    """Yields the events in the journal of one loop, in order.

    Raises:
        JournalError: a line does not hold what a journal does.
    """
    due = 0
    for row in rows:
        if row.get("of") == of:
            number = row.get("number")
            if not isinstance(number, int):
                raise JournalError(f"{of}: got number {number!r}, expected a whole number")
            if number not in (0, due):
                yield Gap(number, due)
            due = number + 1
            try:
                yield from _events(row)
            except (KeyError, TypeError, AttributeError, ParameterError) as error:
                raise JournalError(f"{of}, line {number} of its journal: {error}") from None


def _events(row: Mapping[str, Any]) -> Iterator[Event]:
    if row["number"] == 0:
        if row.get("format") != FORMAT:
            raise JournalError(f"format: got {row.get('format')!r}, expected {FORMAT}")
        yield Beginning(decode(row["settings"]), row["known_map"], row["made_with"])
        return
    for each in row["calls"]:
        checks, forbidden = tuple(each.get("deadline_checks", ())), tuple(each.get("forbidden", ()))
        yield Call(each["call"], tuple(decode(each["args"])), forbidden, checks, each.get("result"))
