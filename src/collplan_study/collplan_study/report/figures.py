"""Figures: the style of all, the paper's panels over T_map, and overlaid paths on maps of grown obstacles."""

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, PathPatch
from matplotlib.path import Path as Outline
from shapely import get_parts
from shapely.geometry.base import BaseGeometry

from collplan_core.evaluation.run_end import REACHED
from collplan_core.worlds import World
from collplan_study.analysis.cells import Cell
from collplan_study.analysis.comparisons import LENGTH, PANELS, TIME
from collplan_study.analysis.paths import RunPath, grown_obstacles, obstacles
from collplan_study.analysis.statistics import MEAN, SPREAD, Estimate

COLOURS = {"harness": "#0072b2", "high_risk": "#d55e00", "low_risk": "#009e73"}
"""Colours of Okabe and Ito, which the colour-blind can distinguish."""
OTHER_COLOURS = ("#882255", "#8f5a00", "#332288", "#555555")
"""Dark enough for thin lines on white."""
MARKS = "os^Dv*P"
SOLID, GROWN, FAILED, GROUND = "#5b6472", "#d5d9df", "#000000", "#ffffff"
AXIS_LABELS = {
    (TIME, MEAN): "arrival time, mean [s]",
    (TIME, SPREAD): "arrival time, STD [s]",
    (LENGTH, MEAN): "path length, mean [m]",
    (LENGTH, SPREAD): "path length, STD [m]",
}
STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e7eb",
    "axes.axisbelow": True,
    "legend.frameon": False,
    "svg.hashsalt": "study",
}


@dataclass(frozen=True, eq=False)
class PathPanel:
    """A map of a world with the paths of a strategy's runs.

    Attributes:
        world: world of the runs.
        radius: radius of the robot [m].
        tolerance: tolerance of the goal [m].
        strategy, map_period: strategy and T_map [s] of the runs.
        paths: paths of the runs.
    """

    world: World
    radius: float
    tolerance: float
    strategy: str
    map_period: float
    paths: Sequence[RunPath]


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
            found = [(cell.map_period, cell.levels[place]) for cell in cells if cell.strategy == strategy]
            _draw_levels(axes, found, shift, strategy, strategies)
        periods = sorted({cell.map_period for cell in cells})
        axes.set(xticks=periods, xlim=(periods[0] - 0.1, periods[-1] + 0.1))
        axes.set_ylim(bottom=0.0)
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=len(names))
    add_caption(figure, f"bars: 95 % intervals; STD between {spread}")
    return figure


@rc_context(STYLE)
def draw_paths(rows: Sequence[Sequence[PathPanel]]) -> Figure:
    """Overlaid paths: a row for each world, a column for each strategy."""
    columns = max(map(len, rows))
    x0, y0, x1, y1 = rows[0][0].world.bounds
    width = 9.0 / columns
    height = min(max(width * (y1 - y0) / (x1 - x0), 1.5), 6.0)
    figure = new_figure(9.0, (height + 0.35) * len(rows))
    strategies = [panel.strategy for panel in rows[0]]
    for row, panels in enumerate(rows):
        for column, panel in enumerate(panels):
            _draw_map(figure.add_subplot(len(rows), columns, row * columns + column + 1), panel, strategies)
    return figure


@rc_context(STYLE)
def save_figure(figure: Figure, stem: Path) -> str:
    """Writes stem.png and stem.svg; returns the text of the SVG."""
    figure.savefig(stem.with_name(stem.name + ".png"), dpi=150)
    buffer = BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    stem.with_name(stem.name + ".svg").write_bytes(buffer.getvalue())
    return buffer.getvalue().decode()


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of a size in inches."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def add_caption(figure: Figure, text: str) -> None:
    """Adds a line below the figure that marks it as simulated."""
    figure.supxlabel(f"simulated; {text}", fontsize=8, color=SOLID)


def _look(strategy: str, strategies: Sequence[str]) -> tuple[str, str]:
    """Colour and marker of a strategy among those that are drawn."""
    others = [name for name in strategies if name not in COLOURS]
    colours = COLOURS | dict(zip(others, OTHER_COLOURS * len(others), strict=False))
    place = strategies.index(strategy)
    return colours[strategy], MARKS[place % len(MARKS)]


def _draw_levels(
    axes: Axes, found: Sequence[tuple[float, Estimate]], shift: float, strategy: str, strategies: Sequence[str]
) -> None:
    colour, mark = _look(strategy, strategies)
    x = np.array([period for period, _ in found]) + shift
    # None becomes NaN, which leaves a gap
    value, low, high = np.array([[level.value, level.low, level.high] for _, level in found], dtype=float).T
    axes.plot(x, value, color=colour, marker=mark, markersize=5, linewidth=1.4, label=strategy)
    axes.vlines(x, low, high, color=colour, linewidth=1.2, alpha=0.8)


def _draw_map(axes: Axes, panel: PathPanel, strategies: Sequence[str]) -> None:
    world = panel.world
    _fill(axes, grown_obstacles(world, panel.radius), GROWN)
    _fill(axes, obstacles(world), SOLID)
    colour, _ = _look(panel.strategy, strategies)
    _draw_runs(axes, panel.paths, colour)
    for point, mark in ((world.start, "o"), (world.goal, "*")):
        if point is not None:
            axes.plot(*point, marker=mark, color="#000000", markersize=6 if mark == "o" else 9, zorder=4)
    if world.start is not None:
        axes.add_patch(Circle(tuple(world.start), panel.radius, fill=False, linewidth=0.8, zorder=4))
    if world.goal is not None:
        axes.add_patch(Circle(tuple(world.goal), panel.tolerance, fill=False, linewidth=0.8, linestyle="--", zorder=4))
    _frame(axes, world)
    reached = sum(run.outcome == REACHED for run in panel.paths)
    counts = f"{reached} of {len(panel.paths)} arrive"
    axes.set_title(f"{panel.strategy}, {world.name}, T_map {panel.map_period:g} s: {counts}", fontsize=8)


def _draw_runs(axes: Axes, paths: Sequence[RunPath], colour: str) -> None:
    for run in paths:
        if run.outcome == REACHED:
            axes.plot(*run.points.T, color=colour, linewidth=1.0, alpha=0.8, zorder=3)
        else:
            axes.plot(*run.points.T, color=FAILED, linewidth=1.0, linestyle=":", zorder=3)
            axes.plot(*run.points[-1:].T, marker="x", color=FAILED, markersize=5, zorder=3)
        _mark_impacts(axes, run.impacts, colour)


def _mark_impacts(axes: Axes, points: np.ndarray, colour: str) -> None:
    # half of each lies on an obstacle, which is dark, the other half on the ground
    axes.plot(*points.T, "o", markersize=5, markerfacecolor=GROUND, markeredgecolor=colour, zorder=4)


def _frame(axes: Axes, world: World) -> None:
    x0, y0, x1, y1 = world.bounds
    axes.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal", xticks=[], yticks=[])
    axes.spines[:].set_visible(True)
    axes.spines[:].set(color=SOLID, linewidth=1.5 if world.walled else 0.5)


def _fill(axes: Axes, shape: BaseGeometry, colour: str) -> None:
    parts = [part for part in get_parts(shape) if part.geom_type == "Polygon"]
    rings = [ring for part in parts for ring in (part.exterior, *part.interiors)]
    if rings:
        outline = Outline.make_compound_path(*(Outline(np.asarray(ring.coords), closed=True) for ring in rings))
        axes.add_patch(PathPatch(outline, facecolor=colour, edgecolor="none", zorder=1))
