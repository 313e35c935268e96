"""Tables of a report as Markdown."""

from collections.abc import Iterator, Sequence

from collplan_study.report.content import Table


def markdown_table(table: Table) -> Iterator[str]:
    """Lines of a table under its title."""
    yield from (f"### {table.title}", "", table.note, "")
    yield from map(_row, (table.head, ["---"] * len(table.head), *table.rows))
    yield ""


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
