"""The pictures of a case: the paper's panels over T_map, and overlaid paths."""

from collections.abc import Sequence

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from collplan_core.evaluation.run_end import REACHED
from collplan_study.analysis.cells import LENGTH, PANELS, TIME, Cell, cell_of
from collplan_study.analysis.statistics import MEAN, SPREAD, Estimate
from collplan_study.paper.cases import Case
from collplan_study.paper.results import CaseResults
from collplan_study.report.content import Picture
from collplan_study.report.figures import STYLE, add_caption, look_of, new_figure, saved_picture
from collplan_study.report.maps import draw_paths
from collplan_study.report.study_data import StudyData

WORLDS_DRAWN = 3
"""Worlds of a case whose paths are drawn: those where the fewest runs arrive, the first of equals."""
AXIS_LABELS = {
    (TIME, MEAN): "arrival time, mean [s]",
    (TIME, SPREAD): "arrival time, STD [s]",
    (LENGTH, MEAN): "path length, mean [m]",
    (LENGTH, SPREAD): "path length, STD [m]",
}


def case_pictures(data: StudyData, case: Case, found: CaseResults) -> tuple[list[tuple[str, Cell]], dict[str, Picture]]:
    """Draws the pictures of a case and saves them.

    Returns:
        World and cell of each map of paths, and the pictures `periods` and `paths`.
    """
    arrived, cells = case.runs.filter(outcome=REACHED)["world"].to_list(), case.main_cells
    worlds = [source for source in data.sources if source.world.name in found.worlds]
    drawn = sorted(worlds, key=lambda source: arrived.count(source.world.name))[:WORLDS_DRAWN]
    panels = draw_panels(found.cells, found.spread)
    words = "Mean and STD of arrival time and path length against T_map by strategy"
    paths = draw_paths(data, drawn, {"ablation": case.ablation, **case.point}, cells, deliberate=False)
    pictures = {
        "periods": saved_picture(data.folder, f"{case.name}-map-periods", panels, words),
        "paths": saved_picture(data.folder, f"{case.name}-paths", paths, "Overlaid paths of each strategy"),
    }
    names = [source.world.name for source in drawn]
    return [(name, cell_of(case.runs.filter(world=name), **cell)) for name in names for cell in cells], pictures


@rc_context(STYLE)
def draw_panels(cells: Sequence[Cell], spread: str) -> Figure:
    """Mean and standard deviation of arrival time and path length against T_map, with intervals.

    Args:
        cells: cells of a case.
        spread: name of the units that the standard deviations are taken over.
    """
    figure = new_figure(7.6, 5.6)
    strategies = list(dict.fromkeys(cell.strategy for cell in cells))
    shifts = (np.arange(len(strategies)) - (len(strategies) - 1) / 2) * 0.014
    for place, panel in enumerate(PANELS):
        axes = figure.add_subplot(2, 2, place + 1, xlabel="T_map [s]", ylabel=AXIS_LABELS[panel])
        for strategy, shift in zip(strategies, shifts, strict=True):
            found = [(cell.map_period + shift, cell.levels[place]) for cell in cells if cell.strategy == strategy]
            _draw_levels(axes, found, strategy, *look_of(strategy, strategies))
        periods = sorted({cell.map_period for cell in cells})
        axes.set(xticks=periods, xlim=(periods[0] - 0.1, periods[-1] + 0.1))
        axes.set_ylim(bottom=0.0)
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=len(names))
    add_caption(figure, f"bars: 95 % intervals; STD between {spread}")
    return figure


def _draw_levels(axes: Axes, found: Sequence[tuple[float, Estimate]], name: str, colour: str, mark: str) -> None:
    x = np.array([place for place, _ in found])
    # None becomes NaN, which leaves a gap
    value, low, high = np.array([[level.value, level.low, level.high] for _, level in found], dtype=float).T
    axes.plot(x, value, color=colour, marker=mark, markersize=5, linewidth=1.4, label=name)
    axes.vlines(x, low, high, color=colour, linewidth=1.2, alpha=0.8)
