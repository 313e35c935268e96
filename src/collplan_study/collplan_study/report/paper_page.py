"""The page of a study of the paper's question: do harnessed collisions pay?"""

from collections.abc import Iterator

from collplan_study.analysis.cases import Case, cases_of
from collplan_study.analysis.comparisons import HOLDS, OPPOSITE, REVERSED, SAME
from collplan_study.analysis.paper_results import CaseResults, PaperResults
from collplan_study.report.ablation_tables import METHOD, ablation_tables
from collplan_study.report.case_tables import case_tables
from collplan_study.report.markup import bullets, heading, paragraph, section
from collplan_study.report.paper_pictures import case_pictures
from collplan_study.report.study_data import StudyData

REMARKS = {
    "corridor": (
        "This world was chosen among valid ones so that low_risk takes the detour and the others the narrow passages, "
        "as in the paper's figure: it shows the mechanism and is no independent evidence for it."
    ),
    "random": "Generated worlds, laid out for no strategy: the fairer comparison.",
}
"""Remarks on families of worlds, without which their numbers mislead."""


def paper_page(data: StudyData, results: PaperResults) -> Iterator[str]:
    """HTML of the page but its closing sections. Draws the figures and saves them."""
    yield heading(1, "Does harnessing collisions pay?")
    yield paragraph(f"{len(data.runs)} simulated runs. Nothing here was measured on a robot.")
    yield bullets(_verdicts(case) for case in results.cases)
    yield paragraph(_method(results))
    cases = [case for case in cases_of(data.runs) if not case.ablation]
    for case, found in zip(cases, results.cases, strict=True):
        yield from _case_section(data, case, found)
    if results.ablations:
        yield heading(2, "Ablations")
        yield paragraph(METHOD)
        for each in ablation_tables(results.ablations):
            yield from section(3, each)


def _case_section(data: StudyData, case: Case, found: CaseResults) -> Iterator[str]:
    yield heading(2, f"{found.name} ({len(found.worlds)} worlds)" if len(found.worlds) > 1 else found.name)
    if found.family in REMARKS:
        yield paragraph(REMARKS[found.family])
    for each in case_tables(found, case_pictures(data, case, found)):
        yield from section(3, each)


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
