"""The picture of a case: overlaid paths on maps of grown obstacles."""

from collections.abc import Mapping, Sequence
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
from collplan_study.analysis.results import CaseResults
from collplan_study.report.figures import COLOURS, SOLID, STYLE, Picture, new_figure, saved_picture
from collplan_study.run.rows import PATHS
from collplan_study.run.study_folder import StudyData

GROWN, FAILED, GROUND = "#d5d9df", "#000000", "#ffffff"


def paths_picture(data: StudyData, found: CaseResults) -> Picture:
    """Draws paths of a case and saves the picture."""
    worlds = [gain["world"] for gain in found.by_world] or found.worlds
    drawn = list(dict.fromkeys([*worlds[:2], worlds[-1]]))
    where = f"{len(drawn)} of {len(found.worlds)} worlds, where least is saved, and last where most is"
    figure, name = draw_paths(data, found, drawn), found.case.name
    return saved_picture(data.folder, f"{name}-paths", figure, f"{name}: paths in {where}")


@rc_context(STYLE)
def draw_paths(data: StudyData, found: CaseResults, names: Sequence[str]) -> Figure:
    """Overlaid paths of a case's runs: a row for each world, a column for each strategy."""
    cells, worlds = found.main_cells, {source.world.name: source.world for source in data.sources}
    x0, y0, x1, y1 = worlds[names[0]].bounds
    height = min(max(9.0 / len(cells) * (y1 - y0) / (x1 - x0), 1.5), 6.0)
    figure = new_figure(9.0, (height + 0.35) * len(names))
    # the axes of the case outrank the parameters
    values = {**data.provenance["parameters"], **found.case.rows(data.runs, "").row(0, named=True)}
    for place, (name, cell) in enumerate((name, cell) for name in names for cell in cells):
        axes, world = figure.add_subplot(len(names), len(cells), place + 1), worlds[name]
        labels = {"world": name, "ablation": "", **found.case.point}
        labels |= {"strategy": cell.strategy, "map_period_s": cell.map_period}
        ends = data.runs.filter(**labels).select("trial", "outcome")
        _draw_obstacles(axes, world, values["robot.radius"])
        _draw_runs(axes, data, labels, ends, COLOURS[place % len(cells) % len(COLOURS)])
        _draw_ends(axes, world, values["robot.radius"], values["planner.goal_tolerance"])
        arrive = f"{ends.filter(outcome=REACHED).height} of {ends.height} arrive"
        axes.set_title(f"{cell.strategy}, {name}, T_map {cell.map_period:g} s: {arrive}", fontsize=8)
    return figure


def _draw_obstacles(axes: Axes, world: World, radius: float) -> None:
    circles = [Point(x, y).buffer(r, quad_segs=32) for x, y, r in world.circles]
    solid = unary_union([*map(Polygon, world.polygons), *circles])
    # where the centre of the robot cannot be
    arena, grown = box(*world.bounds), solid.buffer(radius, quad_segs=32)
    if world.walled:
        grown = grown.union(arena.difference(arena.buffer(-radius)))
    _fill(axes, grown.intersection(arena), GROWN)
    _fill(axes, solid, SOLID)
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


def _draw_runs(axes: Axes, data: StudyData, labels: Mapping[str, Any], ends: pl.DataFrame, colour: str) -> None:
    points = pl.scan_parquet(data.folder / PATHS).filter(**labels).select("trial", "x", "y").collect()
    impacts = data.impacts.filter(**labels, deliberate=True)
    for trial, x, y, outcome in points.join(ends, on="trial", maintain_order="left").iter_rows():
        if outcome == REACHED:
            axes.plot(x, y, color=colour, linewidth=1.0, alpha=0.8, zorder=3)
        else:
            axes.plot(x, y, color=FAILED, linewidth=1.0, linestyle=":", zorder=3)
            axes.plot(x[-1:], y[-1:], marker="x", color=FAILED, markersize=5, zorder=3)
        # half of each lies on an obstacle, which is dark, the other half on the ground
        hits = impacts.filter(trial=trial).select("x", "y").to_numpy()
        axes.plot(*hits.T, "o", markersize=5, markerfacecolor=GROUND, markeredgecolor=colour, zorder=4)


def _draw_ends(axes: Axes, world: World, radius: float, tolerance: float) -> None:
    ends = (world.start, "o", 6, radius, "-"), (world.goal, "*", 9, tolerance, "--")
    for point, mark, size, around, style in ends:
        if point is not None:
            axes.plot(*point, marker=mark, color="#000000", markersize=size, zorder=4)
            axes.add_patch(Circle(tuple(point), around, fill=False, linewidth=0.8, linestyle=style, zorder=4))
