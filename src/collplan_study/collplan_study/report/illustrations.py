"""The figures of a case, drawn and put into the study's folder."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from collplan_study.analysis.cells import Cell, cell_of
from collplan_study.analysis.comparisons import main_cells
from collplan_study.analysis.paths import read_paths
from collplan_study.analysis.results import CaseResults
from collplan_study.analysis.runs import Case, Runs
from collplan_study.question.sources import Source
from collplan_study.report.figures import PathPanel, draw_panels, draw_paths, save_figure
from collplan_study.tables.tables import PATHS
from omnipuck_sim.trial import REACHED

FIGURES = "figures"
WORLDS_DRAWN = 3
"""Of a case: those where the fewest runs arrive, the first of equals."""


@dataclass(frozen=True)
class Illustrations:
    """The figures of a case as SVG, their files without the ending, and what is drawn of which world in the second."""

    panels: str
    paths: str
    files: tuple[str, str]
    drawn: tuple[tuple[str, Cell], ...]


def illustrate(
    folder: Path, provenance: Mapping[str, Any], sources: Sequence[Source], case: Case, found: CaseResults
) -> Illustrations:
    """Draws the figures of a case into figures/."""
    (folder / FIGURES).mkdir(exist_ok=True)
    names = tuple(f"{FIGURES}/{file_name(case.name)}-{kind}" for kind in ("map-periods", "paths"))
    arrivals = Counter(case.runs.where(outcome=REACHED).columns["world"].tolist())
    worlds = [source for source in sources if source.world.name in found.worlds]
    drawn = sorted(worlds, key=lambda source: arrivals[source.world.name])[:WORLDS_DRAWN]
    rows = [path_panels(folder, provenance, source, case, main_cells(case)) for source in drawn]
    return Illustrations(
        save_figure(draw_panels(found.cells, found.spread), folder / names[0]),
        save_figure(draw_paths(rows), folder / names[1]),
        (names[0], names[1]),
        tuple((source.world.name, cell) for source in drawn for cell in _cells(case, source.world.name)),
    )


def _cells(case: Case, world: str) -> Iterator[Cell]:
    for cell in main_cells(case):
        yield cell_of(cell["strategy"], cell["map_period_s"], case.runs.where(world=world))


def path_panels(
    folder: Path,
    provenance: Mapping[str, Any],
    source: Source,
    case: Case,
    cells: Sequence[Mapping[str, Any]],
    impacts: Runs | None = None,
) -> list[PathPanel]:
    """One map for each of these cells with its runs in a world, and with their impacts if given."""
    values = {**provenance["parameters"], **source.values, **case.point}
    return [
        PathPanel(
            source.world, values["robot.radius"], values["planner.goal_tolerance"], cell["strategy"],
            cell["map_period_s"], list(read_paths(folder / PATHS, case, source.world.name, cell, impacts)),
        )
        for cell in cells
    ]  # fmt: skip


def file_name(text: str) -> str:
    """A name without what a file's must not hold."""
    return re.sub(r"[^\w.-]+", "-", text).strip("-")
