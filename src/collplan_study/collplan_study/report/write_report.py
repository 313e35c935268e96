"""Writes the report of a study: report.html, a page without external files, and table.json."""

import json
import os
from pathlib import Path
from pkgutil import resolve_name

from collplan_study.analysis.pairs import distinct
from collplan_study.question.specification import specification_of
from collplan_study.report.closing import closing_values
from collplan_study.report.content import environment
from collplan_study.report.study_data import read_study
from collplan_study.run.study_folder import REPORT

RESULTS = "table.json"


def write_report(folder: Path) -> None:
    """Writes the report of a study whose tables are in the folder.

    Raises:
        StudyError: the folder does not hold a study.
    """
    data = read_study(folder)
    specification = specification_of(bool(data.provenance["question"].get("bounces")))
    report = resolve_name(specification.report)(data)
    _replace(folder / RESULTS, json.dumps(report.record, indent=2, allow_nan=False) + "\n")
    families = ", ".join(distinct(data.runs, "family"))
    values = {"families": families, **closing_values(data.runs, data.provenance), **report.values}
    _replace(folder / REPORT, environment().get_template(report.template).render(values))


def _replace(path: Path, text: str) -> None:
    part = path.with_name(f".{path.name}.part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)
