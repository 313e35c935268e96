"""trajectory.png: picture of the world and the robot's path through it."""

import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_ros.run.impacts import Impacts
from collplan_ros.run.picture.palette import (
    DELIBERATE,
    FORESEEN,
    GOAL,
    OBSTACLE,
    OTHER,
    OUTLINE,
    PLAN,
    WALL,
    speed_colors,
)
from collplan_ros.run.run_log import PlanRow, RunLog

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection

PLAN_PERIOD = 0.6
"""Shortest time between two plans drawn [s]; all of them would hide the path."""
START = "#4a4a4a"
FAINT = 0.45
"""Opacity of plans."""
SHADES = 64
"""Number of colours that speeds are shown in."""
WIDTH, AROUND, TITLE_LINE = 7.0, 1.4, 0.2
"""Width of the picture; height of what is around the arena, and of each line of the title [inch]."""
TITLE_SIZE, TITLE_WIDTH = 10, 80
"""Font size of the title [points], and characters of a line of it."""


def draw_trajectory(
    path: Path,
    log: RunLog,
    impacts: Impacts,
    world: World,
    goal: np.ndarray,
    settings: Settings,
    title: str,
) -> None:
    """Writes a picture of world, path coloured by speed, impacts, some plans, start and goal (2,) [m].

    The title may have several lines.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    x0, y0, x1, y1 = world.bounds
    figure = Figure(figsize=(WIDTH, WIDTH), layout="constrained")
    FigureCanvasAgg(figure)
    lines = [part for line in title.splitlines() for part in textwrap.wrap(line, TITLE_WIDTH)]
    # of the figure, which is wider than the axes; a world's name may hold what matplotlib takes for formulas
    figure.suptitle("\n".join(lines), fontsize=TITLE_SIZE, parse_math=False)
    figure.set_figheight(0.76 * WIDTH * (y1 - y0) / (x1 - x0) + AROUND + TITLE_LINE * len(lines))
    axes = figure.add_subplot()
    _draw_world(axes, world)
    _draw_plans(axes, log.plans.values())
    _draw_ends(axes, log, goal, settings)
    speeds = _draw_path(axes, log, settings.robot.max_speed)
    if speeds is not None:
        figure.colorbar(speeds, ax=axes, label="speed [m/s]", shrink=0.85, pad=0.02)
    _draw_impacts(axes, impacts)
    _label(axes, world)
    # the layout keeps it apart from the axis labels, whatever the arena's shape
    figure.legend(loc="outside lower center", ncols=6, frameon=False, fontsize=8, columnspacing=1.2, handletextpad=0.6)
    figure.savefig(path, dpi=150)


def _draw_world(axes: "Axes", world: World) -> None:
    from matplotlib.patches import Circle, Polygon, Rectangle

    for corners in world.polygons:
        axes.add_patch(Polygon(corners, closed=True, facecolor=OBSTACLE, edgecolor=WALL, linewidth=0.8))
    for x, y, r in world.circles:
        axes.add_patch(Circle((x, y), r, facecolor=OBSTACLE, edgecolor=WALL, linewidth=0.8))
    x0, y0, x1, y1 = world.bounds
    style, width = ("-", 3.0) if world.walled else (":", 1.0)
    axes.add_patch(Rectangle((x0, y0), x1 - x0, y1 - y0, fill=False, edgecolor=WALL, linewidth=width, linestyle=style))


def _draw_plans(axes: "Axes", plans: Iterable[PlanRow]) -> None:
    last = -np.inf
    for plan in plans:
        if plan.stamp - last >= PLAN_PERIOD:
            axes.plot(
                *plan.positions.T,
                color=PLAN,
                alpha=FAINT,
                linewidth=1.0,
                zorder=2,
                label="plans" if last == -np.inf else None,
            )
            axes.plot(*plan.positions[-1], "o", color=PLAN, alpha=FAINT, markersize=2.5, zorder=2)
            last = plan.stamp


def _draw_ends(axes: "Axes", log: RunLog, goal: np.ndarray, settings: Settings) -> None:
    from matplotlib.patches import Circle

    radius, tolerance = settings.robot.radius, settings.planner.goal_tolerance
    axes.add_patch(Circle((goal[0], goal[1]), tolerance, facecolor=GOAL, alpha=0.2, edgecolor="none"))
    axes.plot(*goal, marker="*", color=GOAL, markersize=11, linestyle="none", label="goal", zorder=5)
    if log.track:
        start = log.track[0]
        axes.add_patch(Circle((start.x, start.y), radius, fill=False, edgecolor=START, linewidth=1.2, zorder=4))
        axes.plot(start.x, start.y, "o", color=START, markersize=4, linestyle="none", label="start", zorder=4)


def _draw_path(axes: "Axes", log: RunLog, top_speed: float) -> "LineCollection | None":
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap

    if len(log.track) < 2:
        return None
    track = np.array(log.track)
    points = track[:, 1:3]
    speed = np.hypot(track[:, 4], track[:, 5])
    pieces = list(np.stack([points[:-1], points[1:]], axis=1))
    # colours and their range are those of the live page
    colors = LinearSegmentedColormap.from_list("speed", speed_colors(np.linspace(0.0, 1.0, SHADES)) / 255.0)
    lines = LineCollection(pieces, cmap=colors, linewidth=2.6, capstyle="round", zorder=3)
    lines.set_array(speed[:-1])
    lines.set_clim(0.0, top_speed)
    axes.add_collection(lines)
    return lines


def _draw_impacts(axes: "Axes", impacts: Impacts) -> None:
    for chosen, marker, color, label in (
        (impacts.verdicts.deliberate, "D", DELIBERATE, "impact, deliberate"),
        (impacts.verdicts.foreseen & ~impacts.verdicts.deliberate, "o", FORESEEN, "impact, foreseen"),
        (~impacts.verdicts.foreseen & ~impacts.verdicts.deliberate, "X", OTHER, "impact, other"),
    ):
        if chosen.any():
            points = impacts.points[chosen]
            axes.plot(
                *points.T,
                marker,
                color=color,
                markeredgecolor=OUTLINE,
                markeredgewidth=0.8,
                markersize=7,
                label=label,
                zorder=6,
            )


def _label(axes: "Axes", world: World) -> None:
    x0, y0, x1, y1 = world.bounds
    margin = 0.03 * max(x1 - x0, y1 - y0)
    axes.set(
        aspect="equal", xlim=(x0 - margin, x1 + margin), ylim=(y0 - margin, y1 + margin), xlabel="x [m]", ylabel="y [m]"
    )
