"""Tables of a report as Markdown."""

from collections.abc import Iterator, Sequence

from collplan_study.report.content import Section


def markdown_table(section: Section) -> Iterator[str]:
    """Lines of a section's table under its title."""
    yield from (f"### {section.title}", "", section.note, "")
    yield from map(_row, (section.head, ["---"] * len(section.head), *section.rows))
    yield ""


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
