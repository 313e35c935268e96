"""Writes the report of a study: report.html, a page without external files, table.json and tables.md of bounces."""

import json
import os
from collections.abc import Iterator
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

from collplan_study.analysis.bounce_results import bounce_results_of
from collplan_study.analysis.paper_results import paper_results_of
from collplan_study.report.bounce_document import bounce_document
from collplan_study.report.bounce_page import bounce_page
from collplan_study.report.bounce_pictures import bounce_pictures
from collplan_study.report.closing_sections import assumed_section, failure_section, origin_section
from collplan_study.report.paper_page import paper_page
from collplan_study.report.study_data import StudyData, read_study
from collplan_study.run.study_folder import REPORT

RESULTS, PAGE, DOCUMENT = "table.json", "report_page.html", "tables.md"


def write_report(folder: Path) -> None:
    """Writes the report of a study whose tables are in the folder.

    Raises:
        StudyError: the folder does not hold a study.
    """
    data = read_study(folder)
    body = _bounces(data) if data.provenance["question"].get("bounces") else _paper(data)
    closing = (*failure_section(data.runs), *assumed_section(data.provenance), *origin_section(data.provenance))
    template = Template((files("collplan_study.report") / PAGE).read_text(encoding="utf-8"))
    title = f"Study: {', '.join(data.runs.distinct('family'))} (simulated)"
    _replace(folder / REPORT, template.substitute(title=escape(title), body="\n".join((*body, *closing))))


def _bounces(data: StudyData) -> Iterator[str]:
    results = bounce_results_of(data.provenance["question"]["strategies"], data.runs, data.impacts)
    _replace(data.folder / RESULTS, _as_json(results.record()))
    _replace(data.folder / DOCUMENT, bounce_document(results, data.provenance))
    return bounce_page(results, data.provenance, bounce_pictures(data, results), len(data.runs))


def _paper(data: StudyData) -> Iterator[str]:
    results = paper_results_of(data.runs)
    _replace(data.folder / RESULTS, _as_json(results.record()))
    return paper_page(data, results)


def _as_json(record: dict[str, object]) -> str:
    return json.dumps(record, indent=2, allow_nan=False) + "\n"


def _replace(path: Path, text: str) -> None:
    part = path.with_name(f".{path.name}.part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)
