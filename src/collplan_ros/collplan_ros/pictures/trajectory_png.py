"""trajectory.png: picture of the world and the robot's path through it."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_ros.runs.impact_log import Impacts
from collplan_ros.runs.run_log import PlanRow, RunLog

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection

PLAN_PERIOD = 0.6
"""Shortest time between two plans drawn [s]; all of them would hide the path."""
OBSTACLE, WALL = "#5b6472", "#2f353d"
PLAN, START, GOAL = "#7aa6d8", "#4a4a4a", "#1a8f4c"
FORESEEN, UNFORESEEN = "#f2a900", "#d7263d"


def draw_trajectory(
    path: Path,
    log: RunLog,
    impacts: Impacts,
    world: World,
    goal: np.ndarray,
    settings: Settings,
    title: str,
) -> None:
    """Writes a picture of world, path coloured by speed, impacts, some plans, start and goal (2,) [m]."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    x0, y0, x1, y1 = world.bounds
    width = 7.0
    figure = Figure(figsize=(width, 0.86 * width * (y1 - y0) / (x1 - x0) + 1.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    _draw_world(axes, world)
    _draw_plans(axes, log.plans)
    _draw_ends(axes, log, goal, settings)
    speeds = _draw_path(axes, log)
    if speeds is not None:
        figure.colorbar(speeds, ax=axes, label="speed [m/s]", shrink=0.85, pad=0.02)
    _draw_impacts(axes, impacts)
    _label(axes, world, title)
    # the layout keeps it apart from the axis labels, whatever the arena's shape
    figure.legend(loc="outside lower center", ncols=5, frameon=False, fontsize=8)
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


def _draw_plans(axes: "Axes", plans: list[PlanRow]) -> None:
    last = -np.inf
    for plan in plans:
        if plan.stamp - last >= PLAN_PERIOD:
            axes.plot(
                *plan.positions.T, color=PLAN, linewidth=1.0, zorder=2, label="plans" if last == -np.inf else None
            )
            axes.plot(*plan.positions[-1], "o", color=PLAN, markersize=2.5, zorder=2)
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


def _draw_path(axes: "Axes", log: RunLog) -> "LineCollection | None":
    from matplotlib.collections import LineCollection

    if len(log.track) < 2:
        return None
    track = np.array(log.track)
    points = track[:, 1:3]
    speed = np.hypot(track[:, 4], track[:, 5])
    lines = LineCollection(
        list(np.stack([points[:-1], points[1:]], axis=1)), cmap="plasma", linewidth=2.6, capstyle="round", zorder=3
    )
    lines.set_array(speed[:-1])
    lines.set_clim(0.0, max(0.1, float(speed.max())))
    axes.add_collection(lines)
    return lines


def _draw_impacts(axes: "Axes", impacts: Impacts) -> None:
    for chosen, color, label in (
        (impacts.foreseen, FORESEEN, "impact, foreseen"),
        (~impacts.foreseen, UNFORESEEN, "impact"),
    ):
        if chosen.any():
            points = impacts.points[chosen]
            axes.plot(
                *points.T,
                "X",
                color=color,
                markeredgecolor="black",
                markeredgewidth=0.6,
                markersize=8,
                label=label,
                zorder=6,
            )


def _label(axes: "Axes", world: World, title: str) -> None:
    x0, y0, x1, y1 = world.bounds
    margin = 0.03 * max(x1 - x0, y1 - y0)
    axes.set(
        aspect="equal", xlim=(x0 - margin, x1 + margin), ylim=(y0 - margin, y1 + margin), xlabel="x [m]", ylabel="y [m]"
    )
    # a world's path may hold what matplotlib takes for formulas
    axes.set_title(title, fontsize=10, parse_math=False)
