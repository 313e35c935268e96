"""time_to_goal_cycle.png: what one cycle of `bounce` remembers, infers, tries and chooses."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize

from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.time_to_goal_planner.boundary_memory.clearance import INFERRED, ClearanceField
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths
from collplan_core.worlds import load_world
from cycles import Cycle, cycle_at, cycles_of_run
from drawing import (
    BOUNDARY,
    CHOICE,
    CONTACT,
    DPI,
    FAINT,
    OBSTACLE,
    TEXT,
    area_key,
    draw_arrow,
    draw_goal,
    draw_robot,
    draw_world,
    line_key,
    mark_key,
    new_figure,
    save,
    show,
)

WORLD = "serpentine:2"
A_WHILE = 0.9
"""So far into the run there is a memory, and the first turn is seen [s]."""
SOON, LATER = 0.35, 0.45
"""The bounce shown is so far ahead [s]."""
FAN = 12
"""Rollouts drawn: the best ones with different first velocities."""
SPEED = 0.22
"""A velocity of 1 m/s is drawn so long [m]."""
MARGIN = 0.1
"""Shown around what is remembered and planned [m]."""
INFERRED_COLOR, WAY = "#b9a7d6", "#2f7fc1"
TIMES = "viridis_r"


class Drawn(NamedTuple):
    """What the picture holds."""

    cycle: Cycle
    path: np.ndarray
    fan: LineCollection


def shown_cycle(world: str = WORLD) -> Cycle:
    """The first cycle of a run, after a while, that is about to bounce."""
    settings = Settings()
    settings = replace(settings, planner=replace(settings.planner, strategy="bounce"))
    for cycle in cycles_of_run(load_world(world), settings):
        ahead = cycle.plan.contacts.times - cycle.state.stamp
        if cycle.state.stamp >= A_WHILE and len(ahead) and SOON <= ahead[0] <= LATER:
            return cycle
    raise LookupError(f"after {A_WHILE} s no plan of a run in {world} bounces {SOON} to {LATER} s later")


def fan_of(cycle: Cycle) -> tuple[np.ndarray, ...]:
    """The best coarse rollouts of a cycle, each (n, 2) [m]: those that it would begin to refine if it took so many."""
    settings = replace(
        cycle.settings, time_to_goal=replace(cycle.settings.time_to_goal, n_starts=FAN, start_proposals=0, proposals=0)
    )
    return cycle_at(cycle.world, settings, cycle.state, cycle.before).plan.candidates.paths


def shortest_path(paths: ShortestPaths, position: np.ndarray) -> np.ndarray:
    """(n, 2) from a position over the waypoints to the goal [m]."""
    points = [position]
    while True:
        i, j = np.rint((points[-1] - paths.origin) / paths.spacing).astype(int)
        k = paths.waypoint[i, j]
        if k < 0:
            raise LookupError(f"no path leads from {points[-1]} to the goal")
        points.append(paths.waypoints[k])
        if k == 0:
            return np.array(points)


def velocity_before(plan: Plan, contact: int) -> np.ndarray:
    """(2,) with which a plan comes to one of its contacts [m/s]."""
    return plan.velocities[np.searchsorted(plan.times, plan.contacts.times[contact]) - 1]


def draw(path: Path, dpi: int = DPI) -> Drawn:
    """Writes the picture."""
    cycle = shown_cycle()
    figure = new_figure(9.6)
    known, chosen = figure.subplots(2, 1)
    way = _draw_known(known, cycle)
    fan = _draw_rollouts(chosen, cycle)
    costs = _draw_ends(chosen, cycle)
    _draw_plan(chosen, cycle.plan)
    known.set_title("(a) what is remembered and inferred, and the shortest path over it")
    chosen.set_title("(b) coarse rollouts and the plan")
    for axes in (known, chosen):
        draw_goal(axes, np.asarray(cycle.world.goal), cycle.settings.planner.goal_tolerance)
        draw_robot(axes, cycle.state.position, cycle.settings.robot.radius)
        show(axes, _view(cycle))
    figure.colorbar(
        costs,
        ax=[known, chosen],
        orientation="vertical",
        shrink=0.42,
        aspect=30,
        anchor=(0.0, 0.04),
        pad=0.01,
        extend="max",
        label="ends of the rollouts: time to the goal\nabove the least, contacts included [s]",
    )
    figure.suptitle(f"One cycle of bounce, simulated in {cycle.world.name}", fontsize=11)
    figure.legend(handles=_key(), loc="outside lower center", ncols=3, columnspacing=1.6)
    save(figure, path, dpi)
    return Drawn(cycle, way, fan)


def _view(cycle: Cycle) -> tuple[float, float, float, float]:
    """The part of the world that is remembered or planned through."""
    points = np.vstack([cycle.memory.remembered.pieces.reshape(-1, 2), cycle.plan.positions, cycle.world.goal])
    (x0, y0), (x1, y1) = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    return x0, y0, x1, y1


def _draw_known(axes: Axes, cycle: Cycle) -> np.ndarray:
    remembered = cycle.memory.remembered
    draw_world(axes, cycle.world)
    _draw_inferred(axes, remembered.field)
    _draw_pieces(axes, remembered.pieces)
    way = shortest_path(cycle.memory.paths, cycle.state.position)
    axes.plot(*way.T, color=WAY, linewidth=1.8, zorder=6)
    axes.plot(*way[1:-1].T, "o", color=WAY, markersize=5.0, zorder=6)
    return way


def _draw_inferred(axes: Axes, field: ClearanceField) -> None:
    """Where the disc's centre cannot be: within its radius of what was observed, and behind that."""
    x, y = (field.origin[axis] + field.spacing * np.arange(n) for axis, n in enumerate(field.clearance.shape))
    blocked = np.where(field.source == INFERRED, field.clearance, 1.0)
    axes.contourf(x, y, blocked.T, levels=[-10.0, 0.0], colors=[INFERRED_COLOR], alpha=0.6, zorder=1)
    axes.contour(x, y, field.clearance.T, levels=[0.0], colors=[FAINT], linewidths=0.8, linestyles="--", zorder=3)


def _draw_pieces(axes: Axes, pieces: np.ndarray) -> None:
    axes.add_collection(LineCollection(pieces.reshape(-1, 2, 2), color=BOUNDARY, linewidth=3.0, zorder=4))


def _draw_rollouts(axes: Axes, cycle: Cycle) -> LineCollection:
    draw_world(axes, cycle.world)
    _draw_pieces(axes, cycle.memory.remembered.pieces)
    fan = LineCollection(list(fan_of(cycle)), color=FAINT, linewidth=0.8, zorder=5)
    axes.add_collection(fan)
    return fan


def _draw_ends(axes: Axes, cycle: Cycle) -> ScalarMappable:
    candidates = cycle.plan.candidates
    above = candidates.costs - candidates.costs.min()
    order = np.argsort(-above, kind="stable")
    x, y = candidates.positions[order].T
    return axes.scatter(
        x,
        y,
        c=above[order],
        cmap=TIMES,
        norm=Normalize(0.0, 1.5),
        s=3.0,
        zorder=4.5,
        linewidths=0.0,
    )


def _draw_plan(axes: Axes, plan: Plan) -> None:
    axes.plot(*plan.positions.T, color=CHOICE, linewidth=2.4, zorder=8)
    for k, (time, point, after) in enumerate(
        zip(plan.contacts.times, plan.contacts.points, plan.contacts.velocities_after, strict=True)
    ):
        center = np.array([np.interp(time, plan.times, each) for each in plan.positions.T])
        axes.plot(*point, "X", color=CONTACT, markeredgecolor="black", markersize=8.0, zorder=11)
        draw_arrow(axes, center - SPEED * velocity_before(plan, k), center, TEXT)
        draw_arrow(axes, center, center + SPEED * after, TEXT)


def _key() -> list:
    return [
        area_key("obstacles (unknown to the planner)", OBSTACLE),
        line_key("boundaries in memory", BOUNDARY, 3.0),
        area_key("solid inferred behind them", INFERRED_COLOR),
        line_key("limit of the robot's centre", FAINT, 0.8, "--"),
        line_key("shortest path, waypoints", WAY, marker="o"),
        line_key(f"the {FAN} best rollouts, carried on to the goal", FAINT, 0.8),
        line_key("plan", CHOICE, 2.4),
        mark_key("foreseen contact", CONTACT, "X", 8.0, "black"),
        line_key("velocity before and after it", TEXT, 1.6),
    ]
