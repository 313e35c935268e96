"""The report of a study of the paper's question: do harnessed collisions pay?"""

from collections.abc import Iterator
from dataclasses import replace

from collplan_study.analysis.cells import LENGTH, TIME
from collplan_study.analysis.statistics import MEAN, SPREAD
from collplan_study.paper.cases import HOLDS, OPPOSITE, REVERSED, SAME, cases_of
from collplan_study.paper.pictures import AXIS_LABELS, case_pictures
from collplan_study.paper.results import CaseResults, PaperResults, paper_results
from collplan_study.report.content import Report, Section
from collplan_study.report.study_data import StudyData
from collplan_study.report.templates import tables

ROWS = {
    (TIME, MEAN): "Arrival time mean",
    (TIME, SPREAD): "Arrival time STD",
    (LENGTH, MEAN): "Path length mean",
    (LENGTH, SPREAD): "Path length STD",
}
"""Names of the rows of Table I."""

REMARKS = {
    "corridor": (
        "This world was chosen among valid ones so that low_risk takes the detour and the others the narrow passages, "
        "as in the paper's figure: it shows the mechanism and is no independent evidence for it."
    ),
    "random": "Generated worlds, laid out for no strategy: the fairer comparison.",
}
"""Remarks on families of worlds, without which their numbers mislead."""
ABLATIONS = (
    "One change from the defaults at a time. For each strategy: runs that arrive, mean arrival time (a run that "
    "does not arrive counts with the time limit), how much longer that is than as shipped in the same runs, in "
    "percent, and deliberate impacts of all impacts a run. Then the improvement of mean arrival time, in percent."
)


def paper_report(data: StudyData) -> Report:
    """The report of a study."""
    results = paper_results(data.runs)
    return Report(results.record(), _sections(data, results))


def _sections(data: StudyData, results: PaperResults) -> Iterator[Section]:
    counted = f"{data.runs.height} simulated runs. Nothing here was measured on a robot."
    verdicts = [_verdicts(case) for case in results.cases]
    yield Section("Does harnessing collisions pay?", counted, bullets=verdicts, level=1)
    yield Section(note=_method(results))
    cases = [case for case in cases_of(data.runs) if not case.ablation]
    for case, found in zip(cases, results.cases, strict=True):
        title = f"{found.name} ({len(found.worlds)} worlds)" if len(found.worlds) > 1 else found.name
        yield Section(title, REMARKS.get(found.family, ""))
        drawn, pictures = case_pictures(data, case, found)
        levels = AXIS_LABELS.values()
        for table in tables("case_tables.md", case=found, drawn=drawn, rows=ROWS, levels=levels):
            yield replace(table, level=3, picture=pictures.get(table.title))
    if results.ablations:
        yield Section("Ablations", ABLATIONS)
        for table in tables("ablation_tables.md", cases=results.ablations_by_case):
            yield replace(table, level=3)


def _method(results: PaperResults) -> str:
    counts = results.comparisons
    n = sum(counts.values())
    places = f"{counts['table_one']} in Table I, {counts['other_map_periods']} at other T_map, {counts['ablations']} in"
    return (
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
