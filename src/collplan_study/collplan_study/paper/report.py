"""The report of a study of the paper's question: do harnessed collisions pay?"""

from collections.abc import Iterator
from dataclasses import replace

from collplan_study.analysis.cells import LENGTH, TIME
from collplan_study.analysis.statistics import MEAN, SPREAD
from collplan_study.paper.cases import HOLDS, OPPOSITE, REVERSED, SAME, cases_of
from collplan_study.paper.pictures import AXIS_LABELS, case_pictures
from collplan_study.paper.results import PaperResults, paper_results
from collplan_study.report.content import Report, Section
from collplan_study.report.study_data import StudyData
from collplan_study.report.templates import sections

ROWS = {
    (TIME, MEAN): "Arrival time mean",
    (TIME, SPREAD): "Arrival time STD",
    (LENGTH, MEAN): "Path length mean",
    (LENGTH, SPREAD): "Path length STD",
}
"""Names of the rows of Table I."""


def paper_report(data: StudyData) -> Report:
    """The report of a study."""
    results = paper_results(data.runs)
    return Report(results.record(), _page(data, results))


def _page(data: StudyData, results: PaperResults) -> Iterator[Section]:
    verdicts = (HOLDS, SAME, OPPOSITE, REVERSED)
    yield from sections("paper_opening.md", results=results, runs=data.runs.height, verdicts=verdicts)
    cases = [case for case in cases_of(data.runs) if not case.ablation]
    for case, found in zip(cases, results.cases, strict=True):
        drawn, pictures = case_pictures(data, case, found)
        for each in sections("case.md", case=found, drawn=drawn, rows=ROWS, levels=AXIS_LABELS.values()):
            yield replace(each, picture=pictures.get(each.title))
    if results.ablations:
        yield from sections("ablations.md", cases=results.ablations_by_case)
