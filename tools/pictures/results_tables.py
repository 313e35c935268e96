"""Tables of a Markdown document, read by their heading and first row: what they say is written down once."""

import re
from collections.abc import Iterator
from typing import NamedTuple

ESTIMATE = re.compile(r"\**(-?\d+(?:\.\d+)?) \[(-?\d+(?:\.\d+)?), (-?\d+(?:\.\d+)?)\]\**")


class TableError(ValueError):
    """A document that does not hold the table looked for; the message says what was expected."""


class Estimate(NamedTuple):
    """A value and its interval."""

    value: float
    low: float
    high: float


def read_table(text: str, heading: str, header: tuple[str, ...]) -> dict[str, list[str]]:
    """The cells of each row after the first, by the first, of the table with this header in a section.

    Raises:
        TableError: no such section, no such table in it, or a row of another length.
    """
    lines = iter(text.splitlines())
    if not any(line.lstrip("#").strip() == heading and line.startswith("#") for line in lines):
        raise TableError(f"no section {heading!r}")
    for line in lines:
        if line.startswith("#"):
            break
        if _cells(line) == list(header):
            next(lines, None)  # the rule below the header
            return _rows(lines, heading, len(header))
    raise TableError(f"section {heading!r}: no table with the header {' | '.join(header)}")


def _rows(lines: Iterator[str], heading: str, length: int) -> dict[str, list[str]]:
    rows: dict[str, list[str]] = {}
    for line in lines:
        if not line.startswith("|"):
            break
        first, *others = _cells(line)
        if len(others) != length - 1:
            raise TableError(f"section {heading!r}, row {first!r}: got {len(others) + 1} cells, expected {length}")
        rows[first] = others
    if not rows:
        raise TableError(f"section {heading!r}: the table has no rows")
    return rows


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")] if line.startswith("|") else []


def estimate(cell: str) -> Estimate:
    """A value with its interval, as in `**5.5 [4.5, 6.5]**`.

    Raises:
        TableError: the cell says something else.
    """
    found = ESTIMATE.fullmatch(cell)
    if found is None:
        raise TableError(f"cell {cell!r}: expected a number and its interval, as in 5.5 [4.5, 6.5]")
    return Estimate(*map(float, found.groups()))
