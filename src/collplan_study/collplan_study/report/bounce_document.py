"""The tables of a study of bounces as a Markdown document."""

from collections.abc import Iterator, Mapping
from typing import Any

from collplan_study.analysis.bounce_results import BounceResults
from collplan_study.report.bounce_page import METHOD, conditions, summary
from collplan_study.report.bounce_tables import bounce_tables
from collplan_study.report.markdown import markdown_table


def bounce_document(results: BounceResults, provenance: Mapping[str, Any]) -> str:
    """Text of tables.md: the commands that made the numbers, then every table."""
    return "\n".join(_lines(results, provenance))


def _lines(results: BounceResults, provenance: Mapping[str, Any]) -> Iterator[str]:
    yield from ("All figures are simulated.", "", "```")
    yield from (session["command"] for session in provenance["sessions"])
    yield from ("```", "")
    if not results.groups:
        return
    yield from (f"- {line}" for line in summary(results))
    yield from ("", conditions(provenance), "", METHOD, "")
    for each in bounce_tables(results):
        yield from markdown_table(each)
