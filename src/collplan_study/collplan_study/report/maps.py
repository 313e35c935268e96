"""Overlaid paths of runs on maps of grown obstacles."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import polars as pl
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, PathPatch
from matplotlib.path import Path as Outline
from shapely import Point, Polygon, box, get_parts, unary_union
from shapely.geometry.base import BaseGeometry

from collplan_core.evaluation.run_end import REACHED
from collplan_core.worlds import World
from collplan_study.question.sources import Source
from collplan_study.report.figures import SOLID, STYLE, look_of, new_figure
from collplan_study.report.study_data import StudyData
from collplan_study.tables.table_files import PATHS

GROWN, FAILED, GROUND = "#d5d9df", "#000000", "#ffffff"


class RunPath(NamedTuple):
    """Path (n, 2) of a run, how the run ended, and the contact points (k, 2) of the impacts to be marked [m]."""

    points: np.ndarray
    outcome: str
    impacts: np.ndarray


@rc_context(STYLE)
def draw_paths(
    data: StudyData,
    sources: Sequence[Source],
    labels: Mapping[str, Any],
    cells: Sequence[Mapping[str, Any]],
    deliberate: bool,
) -> Figure:
    """Overlaid paths of runs: a row for each world, a column for each cell.

    Args:
        data: the study.
        sources: the worlds.
        labels: ablation and axes of the runs.
        cells: strategy and map_period_s of each column.
        deliberate: whether deliberate impacts are marked.
    """
    x0, y0, x1, y1 = sources[0].world.bounds
    height = min(max(9.0 / len(cells) * (y1 - y0) / (x1 - x0), 1.5), 6.0)
    figure = new_figure(9.0, (height + 0.35) * len(sources))
    strategies = [cell["strategy"] for cell in cells]
    values = {**data.provenance["parameters"], **labels}
    for row, source in enumerate(sources):
        for column, cell in enumerate(cells):
            axes = figure.add_subplot(len(sources), len(cells), row * len(cells) + column + 1)
            paths = list(_paths(data, {**labels, "world": source.world.name, **cell}, deliberate))
            _draw_obstacles(axes, source.world, values["robot.radius"])
            _draw_runs(axes, paths, look_of(cell["strategy"], strategies)[0])
            _draw_ends(axes, source.world, values["robot.radius"], values["planner.goal_tolerance"])
            arrive = f"{sum(run.outcome == REACHED for run in paths)} of {len(paths)} arrive"
            title = f"{cell['strategy']}, {source.world.name}, T_map {cell['map_period_s']:g} s: {arrive}"
            axes.set_title(title, fontsize=8)
    return figure


def _paths(data: StudyData, labels: Mapping[str, Any], deliberate: bool) -> Iterator[RunPath]:
    outcomes = data.runs.filter(**labels).select("trial", "outcome")
    points = pl.scan_parquet(data.folder / PATHS).filter(**labels).select("trial", "x", "y").collect()
    impacts = data.impacts.filter(**labels, deliberate=True) if deliberate else data.impacts.clear()
    for trial, x, y, outcome in points.join(outcomes, on="trial", maintain_order="left").iter_rows():
        yield RunPath(np.column_stack([x, y]), outcome, impacts.filter(trial=trial).select("x", "y").to_numpy())


def _draw_obstacles(axes: Axes, world: World, radius: float) -> None:
    solid = unary_union(
        [*map(Polygon, world.polygons), *(Point(x, y).buffer(r, quad_segs=32) for x, y, r in world.circles)]
    )
    _fill(axes, _grown(world, solid, radius), GROWN)
    _fill(axes, solid, SOLID)
    x0, y0, x1, y1 = world.bounds
    axes.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal", xticks=[], yticks=[])
    axes.spines[:].set_visible(True)
    axes.spines[:].set(color=SOLID, linewidth=1.5 if world.walled else 0.5)


def _draw_ends(axes: Axes, world: World, radius: float, tolerance: float) -> None:
    for point, mark, size in ((world.start, "o", 6), (world.goal, "*", 9)):
        if point is not None:
            axes.plot(*point, marker=mark, color="#000000", markersize=size, zorder=4)
    for point, around, style in ((world.start, radius, "-"), (world.goal, tolerance, "--")):
        if point is not None:
            axes.add_patch(Circle(tuple(point), around, fill=False, linewidth=0.8, linestyle=style, zorder=4))


def _grown(world: World, solid: BaseGeometry, radius: float) -> BaseGeometry:
    """The augmented-obstacle map: where in the bounds the centre of a disc of `radius` [m] cannot be."""
    arena, grown = box(*world.bounds), solid.buffer(radius, quad_segs=32)
    if world.walled:
        grown = grown.union(arena.difference(arena.buffer(-radius)))
    return grown.intersection(arena)


def _draw_runs(axes: Axes, paths: Sequence[RunPath], colour: str) -> None:
    for run in paths:
        if run.outcome == REACHED:
            axes.plot(*run.points.T, color=colour, linewidth=1.0, alpha=0.8, zorder=3)
        else:
            axes.plot(*run.points.T, color=FAILED, linewidth=1.0, linestyle=":", zorder=3)
            axes.plot(*run.points[-1:].T, marker="x", color=FAILED, markersize=5, zorder=3)
        # half of each lies on an obstacle, which is dark, the other half on the ground
        axes.plot(*run.impacts.T, "o", markersize=5, markerfacecolor=GROUND, markeredgecolor=colour, zorder=4)


def _fill(axes: Axes, shape: BaseGeometry, colour: str) -> None:
    parts = [part for part in get_parts(shape) if part.geom_type == "Polygon"]
    rings = [ring for part in parts for ring in (part.exterior, *part.interiors)]
    if rings:
        outline = Outline.make_compound_path(*(Outline(np.asarray(ring.coords), closed=True) for ring in rings))
        axes.add_patch(PathPatch(outline, facecolor=colour, edgecolor="none", zorder=1))
