"""Overlaid paths of runs on maps of grown obstacles."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

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


@dataclass(frozen=True, eq=False)
class RunPath:
    """Path (n, 2) of a run, how the run ended, and the contact points (k, 2) of the impacts to be marked [m]."""

    points: np.ndarray
    outcome: str
    impacts: np.ndarray


@dataclass(frozen=True, eq=False)
class Map:
    """A map of a world with the paths of a strategy's runs at a T_map [s].

    Attributes:
        world: world of the runs.
        radius, tolerance: radius of the robot, tolerance of the goal [m].
        strategy, map_period: of the runs.
        paths: paths of the runs.
    """

    world: World
    radius: float
    tolerance: float
    strategy: str
    map_period: float
    paths: Sequence[RunPath]


def maps_of(
    data: StudyData, source: Source, labels: Mapping[str, Any], cells: Sequence[Mapping[str, Any]], deliberate: bool
) -> list[Map]:
    """A map of a world for each cell, with the paths of the cell's runs by trial.

    Args:
        data: the study.
        source: the world.
        labels: family, ablation and axes of the runs.
        cells: strategy and map_period_s of each.
        deliberate: whether deliberate impacts are marked.
    """
    values = {**data.provenance["parameters"], **labels}
    return [
        Map(
            world=source.world,
            radius=values["robot.radius"],
            tolerance=values["planner.goal_tolerance"],
            strategy=cell["strategy"],
            map_period=cell["map_period_s"],
            paths=list(_paths(data, {**labels, "world": source.world.name, **cell}, deliberate)),
        )
        for cell in cells
    ]


def _paths(data: StudyData, labels: Mapping[str, Any], deliberate: bool) -> Iterator[RunPath]:
    outcomes = data.runs.filter(**labels).select("trial", "outcome")
    points = pl.scan_parquet(data.folder / PATHS).filter(**labels).select("trial", "x", "y").collect()
    impacts = data.impacts.filter(**labels, deliberate=True)
    for trial, x, y, outcome in points.join(outcomes, on="trial", maintain_order="left").iter_rows():
        marked = impacts.filter(trial=trial) if deliberate else impacts.clear()
        yield RunPath(np.column_stack([x, y]), outcome, marked.select("x", "y").to_numpy())


@rc_context(STYLE)
def draw_maps(rows: Sequence[Sequence[Map]]) -> Figure:
    """Overlaid paths: a row for each world, a column for each strategy."""
    columns = max(map(len, rows))
    x0, y0, x1, y1 = rows[0][0].world.bounds
    height = min(max(9.0 / columns * (y1 - y0) / (x1 - x0), 1.5), 6.0)
    figure = new_figure(9.0, (height + 0.35) * len(rows))
    strategies = [each.strategy for each in rows[0]]
    for row, maps in enumerate(rows):
        for column, each in enumerate(maps):
            axes = figure.add_subplot(len(rows), columns, row * columns + column + 1)
            _draw_map(axes, each, look_of(each.strategy, strategies)[0])
    return figure


def _draw_map(axes: Axes, each: Map, colour: str) -> None:
    world = each.world
    solid = unary_union(
        [*map(Polygon, world.polygons), *(Point(x, y).buffer(r, quad_segs=32) for x, y, r in world.circles)]
    )
    _fill(axes, _grown(world, solid, each.radius), GROWN)
    _fill(axes, solid, SOLID)
    _draw_runs(axes, each.paths, colour)
    for point, mark in ((world.start, "o"), (world.goal, "*")):
        if point is not None:
            axes.plot(*point, marker=mark, color="#000000", markersize=6 if mark == "o" else 9, zorder=4)
    if world.start is not None:
        axes.add_patch(Circle(tuple(world.start), each.radius, fill=False, linewidth=0.8, zorder=4))
    if world.goal is not None:
        axes.add_patch(Circle(tuple(world.goal), each.tolerance, fill=False, linewidth=0.8, linestyle="--", zorder=4))
    x0, y0, x1, y1 = world.bounds
    axes.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal", xticks=[], yticks=[])
    axes.spines[:].set_visible(True)
    axes.spines[:].set(color=SOLID, linewidth=1.5 if world.walled else 0.5)
    reached = sum(run.outcome == REACHED for run in each.paths)
    counts = f"{reached} of {len(each.paths)} arrive"
    axes.set_title(f"{each.strategy}, {world.name}, T_map {each.map_period:g} s: {counts}", fontsize=8)


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
