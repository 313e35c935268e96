"""Writes the report of a study: report.html, a page without external files, and table.json."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import polars as pl

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import all_specs
from collplan_core.parameters.spec import Spec
from collplan_study.analysis.pairs import distinct
from collplan_study.question.specification import specification_of
from collplan_study.report.content import environment
from collplan_study.report.study_data import read_study
from collplan_study.run.study_folder import REPORT
from collplan_study.tables.rows import axes_of

SHOWN = 100
"""Failed runs listed at most."""
PHYSICAL = ("robot", "rebound", "mocap", "simulator")
"""Groups of parameters that hold physical constants which a simulated run depends on."""


def closing_values(runs: pl.DataFrame, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the values of the last sections of a study's page, from the rows of its runs and its provenance."""
    labels = ("world", "ablation", "strategy", "map_period_s", *axes_of(runs.columns), "trial", "seed")
    names = (*labels, "outcome", "path_length_m", "impacts", "share_stopped", "error")
    specs = [spec for spec in all_specs().values() if spec.key in provenance["parameters"]]
    return {
        "runs": runs.height,
        "failed": runs.filter(pl.col("outcome") != REACHED).select(names),
        "shown": SHOWN,
        "specs": specs,
        "assumed": list(filter(_is_assumed, specs)),
        "provenance": provenance,
    }


def _is_assumed(spec: Spec) -> bool:
    group, _, name = spec.key.partition(".")
    simulated = group == "simulator" and name not in ("world", "seed", "speed_factor")
    return simulated or (group in PHYSICAL and "(assumed" in spec.doc)


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
