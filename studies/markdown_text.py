"""Tables in Markdown, for the documents and the terminal."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

Row = tuple[str, ...]


@dataclass(frozen=True)
class Section:
    """A section. What it has is shown in the order of these attributes."""

    title: str = ""  # its heading; empty where what is above goes on
    note: str = ""  # explanation of the section
    head: Row = ()  # names of the columns of its table
    rows: Sequence[Row] = ()  # text of its cells


def markdown(*sections: Section) -> str:
    """Sections in Markdown, as text that ends with a line feed."""
    return "\n".join(line for section in sections for part in _parts(section) for line in (*part, "") if part)


def _parts(section: Section) -> Iterator[Sequence[str]]:
    """Lines of each part that a section may have."""
    yield [f"### {section.title}"] if section.title else []
    yield [section.note] if section.note else []
    rows = (section.head, ["---"] * len(section.head), *section.rows) if section.head else ()
    yield ["| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |" for cells in rows]
