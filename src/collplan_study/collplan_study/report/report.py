"""report.html, table.json and the figures of a study: one page that needs nothing but itself; tables.md of bounces."""

import json
import os
from collections.abc import Iterator
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from collplan_study.analysis.bounce_results import bounce_results_of
from collplan_study.analysis.comparisons import HOLDS, OPPOSITE, REVERSED, SAME
from collplan_study.analysis.results import CaseResults, Results, results_of
from collplan_study.analysis.runs import Case, Runs, cases_of, read_runs
from collplan_study.question.sources import Source
from collplan_study.report.ablation_section import ablation_section
from collplan_study.report.barn_section import barn_section
from collplan_study.report.bounce_illustrations import Material, bounce_pictures
from collplan_study.report.bounce_sections import bounce_sections
from collplan_study.report.bounce_summary import bounce_summary
from collplan_study.report.case_section import case_section
from collplan_study.report.closing_sections import assumed_section, failure_section, origin_section
from collplan_study.report.illustrations import illustrate
from collplan_study.report.markup import bullets, heading, paragraph
from collplan_study.run.study_folder import read_provenance, read_sources
from collplan_study.tables.tables import IMPACTS, TABLE

RESULTS, REPORT, PAGE, SUMMARY = "table.json", "report.html", "report_page.html", "tables.md"


def write_report(folder: Path) -> None:
    """Writes table.json, report.html and figures/ of a study whose tables are in the folder.

    Raises:
        StudyError: the folder does not hold a study.
    """
    provenance = read_provenance(folder)
    sources = read_sources(folder, provenance)
    runs = read_runs(folder / TABLE)
    write = _write_bounces if provenance["question"].get("bounces") else _write_paper
    parts = write(folder, provenance, sources, runs)
    closing = (*failure_section(runs), *assumed_section(provenance), *origin_section(provenance))
    template = Template((files("collplan_study.report") / PAGE).read_text(encoding="utf-8"))
    title = f"Study: {', '.join(runs.distinct('family'))} (simulated)"
    _replace(folder / REPORT, template.substitute(title=escape(title), body="\n".join((*parts, *closing))))


def _write_bounces(folder: Path, provenance: dict[str, Any], sources: tuple[Source, ...], runs: Runs) -> Iterator[str]:
    impacts = read_runs(folder / IMPACTS)
    results = bounce_results_of(provenance["question"]["strategies"], runs, impacts)
    _write_record(folder, results.record())
    _replace(folder / SUMMARY, bounce_summary(results, provenance))
    pictures = bounce_pictures(Material(folder, provenance, sources, runs, impacts), results)
    return bounce_sections(results, provenance, pictures, len(runs))


def _write_paper(folder: Path, provenance: dict[str, Any], sources: tuple[Source, ...], runs: Runs) -> Iterator[str]:
    results = results_of(runs)
    _write_record(folder, results.record())
    cases = [case for case in cases_of(runs) if not case.ablation]
    return _paper_sections(folder, provenance, sources, runs, results, cases)


def _write_record(folder: Path, record: dict[str, Any]) -> None:
    _replace(folder / RESULTS, json.dumps(record, indent=2, allow_nan=False) + "\n")


def _paper_sections(
    folder: Path,
    provenance: dict[str, Any],
    sources: tuple[Source, ...],
    runs: Runs,
    results: Results,
    cases: list[Case],
) -> Iterator[str]:
    yield heading(1, "Does harnessing collisions pay?")
    yield paragraph(f"{len(runs)} simulated runs. Nothing here was measured on a robot.")
    yield from _opening(results)
    for case, found in zip(cases, results.cases, strict=True):
        yield from case_section(found, illustrate(folder, provenance, sources, case, found))
        yield from barn_section(case, sources)
    yield from ablation_section(results.ablations)


def _opening(results: Results) -> Iterator[str]:
    yield bullets(_verdicts(case) for case in results.cases)
    counts = results.comparisons
    n = sum(counts.values())
    places = f"{counts['table_one']} in Table I, {counts['other_map_periods']} at other T_map, {counts['ablations']} in"
    yield paragraph(
        "Improvements are 100 (1 - ours / other) in percent, as in the paper. Intervals are 95 % bootstrap intervals "
        f"(BCa), paired by world and seed. {n} comparisons were made ({places} ablations): if nothing differed at all, "
        f"about {0.05 * n:.1f} of their intervals would leave zero out. Intervals from fewer than some 15 runs, or "
        "worlds, are too narrow."
    )


def _verdicts(case: CaseResults) -> str:
    known = [each.verdict for each in case.table_one if each.paper is not None]
    if not known:
        return f"{case.name}: nothing to compare with the paper's Table I (harness against another at 0.2 s)."
    counts = {verdict: known.count(verdict) for verdict in (HOLDS, SAME, OPPOSITE, REVERSED)}
    return (
        f"{case.name}: of {len(known)} signs in the paper's Table I, {counts[HOLDS]} hold with an interval that leaves "
        f"zero out, {counts[SAME]} have the same sign but an interval that does not, {counts[OPPOSITE]} the opposite "
        f"sign without one, {counts[REVERSED]} are reversed with one."
    )


def _replace(path: Path, text: str) -> None:
    part = path.with_name(f".{path.name}.part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)
