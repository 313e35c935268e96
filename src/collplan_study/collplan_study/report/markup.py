"""Pieces of a page: tables, figures, numbers as text."""

import base64
from collections.abc import Iterable, Sequence
from html import escape

from collplan_study.analysis.comparisons import HOLDS, REVERSED
from collplan_study.analysis.statistics import Estimate

CLASSES = {HOLDS: "holds", REVERSED: "reversed"}
"""Verdicts that stand out."""


def heading(level: int, text: str) -> str:
    return f"<h{level}>{escape(text)}</h{level}>"


def paragraph(text: str, kind: str = "") -> str:
    return f'<p class="{kind}">{escape(text)}</p>'


def preformatted(text: str) -> str:
    return f"<pre>{escape(text)}</pre>"


def bullets(texts: Iterable[str]) -> str:
    return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in texts) + "</ul>"


def table(head: Sequence[str], rows: Iterable[Sequence[str]], kind: str = "") -> str:
    """A table whose first column is text; the others are numbers unless its kind is "text"."""
    cells = "".join(f"<th>{escape(name)}</th>" for name in head)
    lines = "".join(f"<tr>{''.join(map(_cell, row))}</tr>\n" for row in rows)
    body = f"<thead><tr>{cells}</tr></thead><tbody>\n{lines}</tbody>"
    return f'<div class="wide"><table class="{kind}">{body}</table></div>'


def folded(summary: str, content: str) -> str:
    """Content that is shown on demand."""
    return f"<details><summary>{escape(summary)}</summary>{content}</details>"


def figure(svg: str, words: str) -> str:
    """A picture that the page itself holds; as an image, so that names inside it do not meet those of another."""
    data = base64.b64encode(svg.encode()).decode()
    return f'<figure><img alt="{escape(words)}" src="data:image/svg+xml;base64,{data}"></figure>'


def with_interval(estimate: Estimate, digits: int, unit: str = "") -> str:
    """Value and interval, or why there is none."""
    if estimate.value is None:
        return f"none ({estimate.note})"
    value = f"{number(estimate.value, digits)}{unit}"
    if estimate.low is None or estimate.high is None:
        return f"{value} ({estimate.note})"
    return f"{value} [{number(estimate.low, digits)}, {number(estimate.high, digits)}]"


def number(value: float | None, digits: int) -> str:
    # + 0.0: no minus before a zero
    return "none" if value is None else f"{round(value, digits) + 0.0:.{digits}f}"


def _cell(text: str) -> str:
    kind = CLASSES.get(text)
    return f'<td class="{kind}">{escape(text)}</td>' if kind else f"<td>{escape(text)}</td>"
