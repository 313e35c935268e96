"""The report of a study of bounces: do deliberate bounces pay?"""

from collplan_core.parameters import Settings
from collplan_study.bounces.pictures import bounce_pictures
from collplan_study.bounces.results import MAIN, bounce_results
from collplan_study.question.question import parse_axes
from collplan_study.report.content import Report
from collplan_study.report.study_data import StudyData

LEAST = 6
"""Worlds listed of each headline group, those where least is saved."""


def bounce_report(data: StudyData) -> Report:
    """The report of a study."""
    provenance = data.provenance
    results = bounce_results(provenance["question"]["strategies"], data.runs, data.impacts)
    axes = {key: value for key, (value,) in parse_axes(provenance["question"]["values"]).items()}
    values = {
        "results": results,
        "trials": provenance["trials"],
        "robot": {**Settings().values(), **provenance["parameters"], **axes},
        "least": LEAST,
        "main": MAIN,
        "pictures": list(bounce_pictures(data, results)) if results.groups else [],
    }
    return Report(results.record(), "bounces.html", values)
