"""The pictures of a case: the paper's panels over T_map, and overlaid paths."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from collplan_core.evaluation.run_end import REACHED
from collplan_study.analysis.cases import Case
from collplan_study.analysis.cells import Cell, cell_of
from collplan_study.analysis.comparisons import main_cells
from collplan_study.analysis.paper_results import CaseResults
from collplan_study.report.content import Picture
from collplan_study.report.figures import draw_panels, draw_paths
from collplan_study.report.pictures import path_panels, saved_picture
from collplan_study.report.study_data import StudyData

WORLDS_DRAWN = 3
"""Worlds of a case whose paths are drawn: those where the fewest runs arrive, the first of equals."""


@dataclass(frozen=True, eq=False)
class CasePictures:
    """The pictures of a case.

    Attributes:
        map_periods: arrival time and path length over T_map.
        paths: overlaid paths in some worlds.
        drawn: world and cell of each map in `paths`.
    """

    map_periods: Picture
    paths: Picture
    drawn: tuple[tuple[str, Cell], ...]


def case_pictures(data: StudyData, case: Case, found: CaseResults) -> CasePictures:
    """Draws the pictures of a case and saves them."""
    arrivals = Counter(case.runs.where(outcome=REACHED).columns["world"].tolist())
    worlds = [source for source in data.sources if source.world.name in found.worlds]
    drawn = sorted(worlds, key=lambda source: arrivals[source.world.name])[:WORLDS_DRAWN]
    panels = draw_panels(found.cells, found.spread)
    words = "Mean and STD of arrival time and path length against T_map by strategy"
    paths = draw_paths([path_panels(data, source, case, main_cells(case)) for source in drawn])
    return CasePictures(
        saved_picture(data, f"{case.name}-map-periods", panels, words),
        saved_picture(data, f"{case.name}-paths", paths, "Overlaid paths of each strategy"),
        tuple((source.world.name, cell) for source in drawn for cell in _cells(case, source.world.name)),
    )


def _cells(case: Case, world: str) -> Iterator[Cell]:
    for cell in main_cells(case):
        yield cell_of(cell["strategy"], cell["map_period_s"], case.runs.where(world=world))
