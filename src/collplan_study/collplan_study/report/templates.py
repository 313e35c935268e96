"""The templates of a report: its page, and its sections as Markdown."""

import base64
import re
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from collplan_study.report.content import Row, Section, as_text, listed, number, with_interval


@cache
def environment(markdown: bool) -> Environment:
    """Environment of the templates of sections in Markdown, else of the page."""
    made = Environment(
        loader=PackageLoader("collplan_study", "templates"),
        autoescape=not markdown,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_in_cell if markdown else None,
    )
    made.filters["base64"] = lambda text: base64.b64encode(text.encode()).decode()
    made.filters |= {"interval": with_interval, "number": number, "text": as_text, "listed": listed}
    return made


def _in_cell(value: Any) -> str:
    """A value as text that neither ends a cell nor a line."""
    return " ".join(str(value).split("\n")).replace("|", "\\|")


def sections(template: str, **values: Any) -> list[Section]:
    """The sections that a template makes of values.

    A section begins with # to ###, for its level, and its title, if it has one. Lines that begin with - are bullets,
    with | rows of its table, the names of columns first and no line below them; the others are its note. A line is
    ended within a cell by <br>.
    """
    text = environment(markdown=True).get_template(template).render(values)
    parts = re.split(r"^(#+)(.*)$", text, flags=re.MULTILINE)[1:]
    return [_section(*part) for part in zip(parts[::3], parts[1::3], parts[2::3], strict=True)]


def _section(level: str, title: str, text: str) -> Section:
    lines = text.split("\n")
    bullets = [_plain(line[2:]) for line in lines if line.startswith("- ")]
    note = " ".join(line.strip() for line in lines if line and not line.startswith(("- ", "|")))
    head, *rows = [_row(line) for line in lines if line.startswith("|")] or [()]
    return Section(_plain(title.strip()), _plain(note), head, rows, bullets=bullets, level=len(level))


def _row(line: str) -> Row:
    return tuple(_plain(cell.strip()) for cell in re.split(r"(?<!\\)\|", line)[1:-1])


def _plain(text: str) -> str:
    return text.replace("\\|", "|").replace("<br>", "\n")
