"""The report of a study of bounces: do deliberate bounces pay?"""

from collections.abc import Iterator, Sequence

from collplan_core.parameters import Settings
from collplan_study.bounces.pictures import bounce_pictures
from collplan_study.bounces.results import MAIN, BounceResults, bounce_results
from collplan_study.question.question import parse_axes
from collplan_study.report.content import Report, Section
from collplan_study.report.study_data import StudyData
from collplan_study.report.templates import sections

LEAST = 6
"""Worlds listed of each headline group, those where least is saved."""


def bounce_report(data: StudyData) -> Report:
    """The report of a study."""
    provenance = data.provenance
    results = bounce_results(provenance["question"]["strategies"], data.runs, data.impacts)
    axes = {key: value for key, (value,) in parse_axes(provenance["question"]["values"]).items()}
    counts = {"runs": data.runs.height, "trials": provenance["trials"]}
    robot = {**Settings().values(), **provenance["parameters"], **axes}
    first, *notes = sections("bounce_opening.md", results=results, robot=robot, **counts)
    tables = sections("bounce_tables.md", results=results, least=LEAST, main=MAIN) if results.groups else []
    return Report(results.record(), _page(data, results, [first, *notes], tables))


def _page(
    data: StudyData, results: BounceResults, opening: Sequence[Section], tables: Sequence[Section]
) -> Iterator[Section]:
    yield from opening
    if not results.groups:
        return
    n = results.comparisons
    yield Section(
        note=f"{n} savings were compared: if nothing differed at all, about {0.05 * n:.1f} of their intervals would "
        "leave zero out. Intervals from fewer than some 15 worlds are too narrow."
    )
    yield from tables
    yield Section("Figures")
    yield from (Section(picture=picture) for picture in bounce_pictures(data, results))
