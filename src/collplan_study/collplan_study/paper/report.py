"""The report of a study of the paper's question: do harnessed collisions pay?"""

from collplan_study.analysis.cells import LENGTH, TIME
from collplan_study.analysis.statistics import MEAN, SPREAD
from collplan_study.paper.cases import HOLDS, OPPOSITE, REVERSED, SAME, cases_of
from collplan_study.paper.pictures import AXIS_LABELS, case_pictures
from collplan_study.paper.results import paper_results
from collplan_study.report.content import Report
from collplan_study.report.study_data import StudyData

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
    cases = [case for case in cases_of(data.runs) if not case.ablation]
    shown = [(found, *case_pictures(data, case, found)) for case, found in zip(cases, results.cases, strict=True)]
    verdicts = (HOLDS, SAME, OPPOSITE, REVERSED)
    values = {"results": results, "cases": shown, "verdicts": verdicts, "rows": ROWS}
    return Report(results.record(), "paper.html", {**values, "levels": list(AXIS_LABELS.values())})
