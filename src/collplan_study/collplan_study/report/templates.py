"""The templates of a report: its page, and its tables as Markdown."""

import base64
import re
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from collplan_study.report.content import Row, Section, number, with_interval


@cache
def environment(markdown: bool) -> Environment:
    """Environment of the templates of tables in Markdown, else of the page."""
    made = Environment(
        loader=PackageLoader("collplan_study", "templates"),
        autoescape=not markdown,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_in_cell if markdown else None,
    )
    made.filters["base64"] = lambda text: base64.b64encode(text.encode()).decode()
    made.filters |= {"interval": with_interval, "number": number}
    return made


def _in_cell(value: Any) -> str:
    """A value as text that neither ends a cell nor a line."""
    return " ".join(str(value).split("\n")).replace("|", "\\|")


def tables(template: str, **values: Any) -> list[Section]:
    """The tables that a template makes of values: each a title, ###, a note, and the rows, the names of columns first.

    A line is ended within a cell by <br>; there is no line below the names.
    """
    text = environment(markdown=True).get_template(template).render(values)
    return [_table(part) for part in re.split("^### ", text, flags=re.MULTILINE)[1:]]


def _table(text: str) -> Section:
    title, *lines = filter(None, text.split("\n"))
    note = " ".join(line.strip() for line in lines if not line.startswith("|"))
    head, *rows = [_row(line) for line in lines if line.startswith("|")] or [()]
    return Section(_plain(title), _plain(note), head, rows)


def _row(line: str) -> Row:
    return tuple(_plain(cell.strip()) for cell in re.split(r"(?<!\\)\|", line)[1:-1])


def _plain(text: str) -> str:
    return text.replace("\\|", "|").replace("<br>", "\n")
