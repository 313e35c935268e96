"""Writes the report of a study: report.html, a page without external files, and table.json."""

import json
from dataclasses import asdict
from pathlib import Path

import polars as pl
from jinja2 import Environment, PackageLoader, StrictUndefined

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import all_specs
from collplan_study.analysis import results
from collplan_study.analysis.statistics import MEAN, SPREAD
from collplan_study.question.specification import BOUNCES, LENGTH, LONGER, PANELS, PAPER, SAVED, SLOWER, TIME
from collplan_study.report.content import number, with_interval
from collplan_study.report.pictures import paths_picture
from collplan_study.run.rows import axes_of
from collplan_study.run.study_folder import REPORT, read_study, replace_file

RESULTS = "table.json"
NAMES = {
    (TIME, MEAN): "arrival time mean",
    (TIME, SPREAD): "arrival time STD",
    (LENGTH, MEAN): "path length mean",
    (LENGTH, SPREAD): "path length STD",
    (TIME, SAVED): "arrival time saved",
    (TIME, SLOWER): "pairs that arrive later",
    (LENGTH, LONGER): "path longer",
}
"""Names of what is compared, by column and measure."""


def write_report(folder: Path) -> None:
    """Writes the report of a study whose tables are in the folder."""
    data = read_study(folder)
    specification = BOUNCES if data.provenance["question"].get("bounces") else PAPER
    found = results.study_results(specification, data.runs, data.impacts)
    replace_file(folder / RESULTS, json.dumps({**results.ABOUT, **asdict(found)}, indent=2, allow_nan=False) + "\n")
    labels = ("world", "ablation", "strategy", "map_period_s", *axes_of(data.runs.columns), "trial", "seed")
    columns = (*labels, "outcome", "path_length_m", "impacts", "share_stopped", "error")
    values = {
        "specification": specification,
        "results": found,
        "pictures": [paths_picture(data, each) for each in found.cases if each.case.headline],
        "names": NAMES,
        "levels": [f"{NAMES[panel]} [{'s' if panel[0] == TIME else 'm'}]" for panel in PANELS],
        "meanings": results.MEANINGS,
        "verdicts": (results.HOLDS, results.SAME, results.OPPOSITE, results.REVERSED),
        "runs": data.runs.height,
        "failed": data.runs.filter(pl.col("outcome") != REACHED).select(columns),
        "specs": [spec for spec in all_specs().values() if spec.key in data.provenance["parameters"]],
        "provenance": data.provenance,
    }
    loader = PackageLoader("collplan_study", "templates")
    page = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    page.filters |= {"interval": with_interval, "number": number}
    replace_file(folder / REPORT, page.get_template(REPORT).render(values))
