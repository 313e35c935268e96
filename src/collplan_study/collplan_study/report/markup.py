"""HTML elements of the report's page."""

import base64
from collections.abc import Iterable, Iterator, Sequence
from html import escape

from collplan_study.analysis.comparisons import HOLDS, REVERSED
from collplan_study.report.content import Picture, Table

CLASSES = {HOLDS: "holds", REVERSED: "reversed"}
"""CSS class of the verdicts that are highlighted."""


def heading(level: int, text: str) -> str:
    return f"<h{level}>{escape(text)}</h{level}>"


def paragraph(text: str, kind: str = "") -> str:
    return f'<p class="{kind}">{escape(text)}</p>'


def preformatted(text: str) -> str:
    return f"<pre>{escape(text)}</pre>"


def bullets(texts: Iterable[str]) -> str:
    return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in texts) + "</ul>"


def section(level: int, each: Table) -> Iterator[str]:
    """A table with its title, note and picture."""
    yield heading(level, each.title)
    if each.note:
        yield paragraph(each.note)
    if each.picture is not None:
        yield figure(each.picture)
        yield paragraph(f"{each.picture.file}.png, {each.picture.file}.svg", "quiet")
    if each.head:
        yield table(each.head, each.rows, "text" if each.text else "")


def table(head: Sequence[str], rows: Iterable[Sequence[str]], kind: str = "") -> str:
    """A table whose first column is text; the others are numbers unless its kind is "text"."""
    cells = "".join(f"<th>{escape(name)}</th>" for name in head)
    lines = "".join(f"<tr>{''.join(map(_cell, row))}</tr>\n" for row in rows)
    body = f"<thead><tr>{cells}</tr></thead><tbody>\n{lines}</tbody>"
    return f'<div class="wide"><table class="{kind}">{body}</table></div>'


def folded(summary: str, content: str) -> str:
    """Content that is shown on demand."""
    return f"<details><summary>{escape(summary)}</summary>{content}</details>"


def figure(picture: Picture) -> str:
    """A picture embedded in the page, as an image so that the ids in its SVG do not clash with those of another."""
    data = base64.b64encode(picture.svg.encode()).decode()
    return f'<figure><img alt="{escape(picture.words)}" src="data:image/svg+xml;base64,{data}"></figure>'


def _cell(text: str) -> str:
    kind = CLASSES.get(text)
    return f'<td class="{kind}">{escape(text)}</td>' if kind else f"<td>{escape(text)}</td>"
