"""Saving figures in the study's folder, and the maps with paths that several of them show."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from collplan_study.analysis.cases import Case
from collplan_study.analysis.paths import read_paths
from collplan_study.analysis.rows import Rows
from collplan_study.question.sources import Source
from collplan_study.report.content import Picture
from collplan_study.report.figures import PathPanel, save_figure
from collplan_study.report.study_data import StudyData
from collplan_study.tables.table_files import PATHS

FIGURES = "figures"
"""Folder of the figures in that of the study."""


def saved_picture(data: StudyData, name: str, figure: Figure, words: str) -> Picture:
    """Saves a figure as figures/NAME.png and .svg; `words` describe it."""
    file = f"{FIGURES}/{_file_name(name)}"
    (data.folder / FIGURES).mkdir(exist_ok=True)
    return Picture(save_figure(figure, data.folder / file), file, words)


def path_panels(
    data: StudyData, source: Source, case: Case, cells: Sequence[Mapping[str, Any]], impacts: Rows | None = None
) -> list[PathPanel]:
    """A map of a world for each cell, with the paths of the cell's runs.

    Args:
        data: the study.
        source: the world.
        case: case that the cells belong to.
        cells: strategy and map_period_s of each.
        impacts: rows of the impacts that are marked; None marks none.
    """
    values = {**data.provenance["parameters"], **case.point}
    return [
        PathPanel(
            world=source.world,
            radius=values["robot.radius"],
            tolerance=values["planner.goal_tolerance"],
            strategy=cell["strategy"],
            map_period=cell["map_period_s"],
            paths=list(read_paths(data.folder / PATHS, case, source.world.name, cell, impacts)),
        )
        for cell in cells
    ]


def _file_name(text: str) -> str:
    # only characters that every file system takes
    return re.sub(r"[^\w.-]+", "-", text).strip("-")
