"""What the pictures share: paper and palette, worlds, local maps and the robot, and how a picture is written."""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyArrowPatch, Patch, PathPatch, Polygon, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.patheffects import withStroke
from PIL import Image

from collplan_core.local_map import LocalMap
from collplan_core.local_map.frontiers import BORDER_RUN, SHADOW_EDGE
from collplan_core.worlds import World

DPI = 150
WIDTH = 8.0
"""Width of a picture [inch]: at 100 pixel an inch that of a README, where letters of 8 points can be read."""

TEXT, FAINT = "#22262c", "#6b7280"
OBSTACLE, OBSTACLE_EDGE = "#d3d7dd", "#a7aeb8"
FREE, BOUNDARY, SCAN = "#e4f3e4", "#4c6b57", "#39424e"
SHADOW, BORDER, PREDICTED = "#e0701a", "#2f7fc1", "#8e3fa8"
ROBOT, GOAL, CHOICE, CONTACT = "#2b2d33", "#1a8f4c", "#d7263d", "#f2a900"
FREE_SPACE_REFERENCE = TEXT
FRONTIER_COLOR = {SHADOW_EDGE: SHADOW, BORDER_RUN: BORDER}

STYLE: dict[str, Any] = {
    "axes.edgecolor": OBSTACLE_EDGE,
    "axes.labelcolor": TEXT,
    "axes.titlesize": 10.0,
    "font.size": 9.0,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "text.color": TEXT,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
}
"""Settings of matplotlib that the pictures are made with."""
N_COLORS = 256


def new_figure(height: float, layout: str = "constrained") -> Figure:
    """An empty picture as wide as all of them, and so high [inch]."""
    figure = Figure(figsize=(WIDTH, height), layout=layout, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: Path, dpi: int = DPI) -> None:
    """Writes a picture; on one machine equal pictures are equal files."""
    path.parent.mkdir(parents=True, exist_ok=True)
    drawn = BytesIO()
    figure.savefig(drawn, format="png", dpi=dpi)
    # a palette takes half the room
    Image.open(drawn).convert("RGB").quantize(N_COLORS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(
        path, optimize=True
    )


def show_square(axes: Axes, center: np.ndarray, half_side: float) -> None:
    """The part of the world within half_side of a point (2,) [m], to scale and without ticks."""
    show(axes, (center[0] - half_side, center[1] - half_side, center[0] + half_side, center[1] + half_side))


def show(axes: Axes, view: tuple[float, float, float, float]) -> None:
    """The part x0, y0, x1, y1 of the world [m], to scale and without ticks."""
    x0, y0, x1, y1 = view
    axes.set(aspect="equal", xlim=(x0, x1), ylim=(y0, y1), xticks=[], yticks=[])


def draw_world(axes: Axes, world: World) -> None:
    """True obstacles and walls."""
    shapes: list[Patch] = [Polygon(corners, closed=True) for corners in world.polygons]
    shapes += [Circle((x, y), r) for x, y, r in world.circles]
    axes.add_collection(PatchCollection(shapes, color=OBSTACLE, linewidth=0.8, zorder=0.5))
    if world.walled:
        x0, y0, x1, y1 = world.bounds
        inner = [(x0, y0), (x0, y1), (x1, y1), (x1, y0), (x0, y0)]
        outer = [(x0 - 1, y0 - 1), (x1 + 1, y0 - 1), (x1 + 1, y1 + 1), (x0 - 1, y1 + 1), (x0 - 1, y0 - 1)]
        codes = [Outline.MOVETO, *[Outline.LINETO] * 4] * 2
        walls = Outline(np.array(outer + inner), codes)
        axes.add_patch(PathPatch(walls, color=OBSTACLE, linewidth=0.8, zorder=0.5))


def draw_free_space(axes: Axes, local_map: LocalMap) -> None:
    """F, and the observed boundaries of the grown obstacles that end it."""
    axes.add_patch(Polygon(local_map.border_points, closed=True, facecolor=FREE, edgecolor="none", zorder=1))
    for run in local_map.observed_boundaries():
        axes.plot(*run.T, color=BOUNDARY, linewidth=1.6, solid_capstyle="round", zorder=3)


def draw_map_border(axes: Axes, local_map: LocalMap) -> None:
    """The square within which the map is."""
    corner, side = local_map.position - local_map.half_side, 2.0 * local_map.half_side
    axes.add_patch(
        Rectangle(
            tuple(corner), side, side, fill=False, edgecolor=FAINT, linewidth=0.8, linestyle=(0, (2, 3)), zorder=2
        )
    )


def draw_frontiers(axes: Axes, local_map: LocalMap) -> dict[int, LineCollection]:
    """The frontiers, shadow edges and border runs told apart: the drawn lines by kind."""
    drawn = {}
    for kind, color in FRONTIER_COLOR.items():
        segments = local_map.segments[local_map.frontier_kind == kind].reshape(-1, 2, 2)
        drawn[kind] = LineCollection(segments, color=color, linewidth=3.0, capstyle="butt", zorder=4)
        axes.add_collection(drawn[kind])
    return drawn


def draw_robot(axes: Axes, position: np.ndarray, radius: float) -> None:
    """The disc of the robot and its centre."""
    axes.add_patch(Circle(tuple(position), radius, facecolor="white", edgecolor=ROBOT, linewidth=1.4, zorder=7))
    axes.plot(*position, "o", color=ROBOT, markersize=3.0, zorder=8)


def draw_goal(axes: Axes, goal: np.ndarray, tolerance: float) -> None:
    """The goal and what counts as arrived."""
    axes.add_patch(Circle(tuple(goal), tolerance, facecolor=GOAL, alpha=0.2, edgecolor="none", zorder=2))
    axes.plot(*goal, marker="*", color=GOAL, markersize=11, linestyle="none", zorder=6)


def draw_arrow(
    axes: Axes,
    start: np.ndarray,
    end: np.ndarray,
    color: str,
    width: float = 1.6,
    zorder: float = 9.0,
) -> None:
    """An arrow between two points (2,) [m]."""
    axes.add_patch(
        FancyArrowPatch(
            tuple(start),
            tuple(end),
            arrowstyle="-|>",
            mutation_scale=5.0 + 3.0 * width,
            color=color,
            linewidth=width,
            shrinkA=0.0,
            shrinkB=0.0,
            zorder=zorder,
        )
    )


def label(axes: Axes, point: np.ndarray, text: str, color: str, offset: tuple[float, float] = (0.0, 0.0)) -> None:
    """A symbol at a point (2,) [m], moved by so many points of type, readable over whatever it covers."""
    axes.annotate(
        text,
        tuple(point),
        offset,
        textcoords="offset points",
        color=color,
        fontsize=11.0,
        ha="center",
        va="center",
        zorder=12,
        path_effects=[withStroke(linewidth=2.5, foreground="white")],
    )


def line_key(text: str, color: str, width: float = 2.0, style: Any = "-", marker: str = "") -> Line2D:
    """An entry of a legend: a line."""
    return Line2D([], [], color=color, linewidth=width, linestyle=style, marker=marker, markersize=5.0, label=text)


def mark_key(text: str, color: str, marker: str, size: float = 6.0, edge: str | None = None) -> Line2D:
    """An entry of a legend: a mark."""
    return Line2D(
        [],
        [],
        color=color,
        marker=marker,
        markersize=size,
        linestyle="none",
        label=text,
        markeredgecolor=edge or color,
    )


def area_key(text: str, color: str, edge: str = "none", hatch: str = "") -> Artist:
    """An entry of a legend: an area."""
    return Patch(facecolor=color, edgecolor=edge, hatch=hatch, label=text)
