"""local_map.png: what one cycle of the paper's planner sees and chooses from. Paper: Figs. 2 and 3."""

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm
from matplotlib.patches import Wedge

from collplan_core.local_map import LocalMap
from collplan_core.local_map.sight import sight_angle
from collplan_core.parameters import Settings
from collplan_core.plan import Candidates
from collplan_core.state import State
from collplan_core.worlds import load_world
from cycles import Cycle, cycle_at
from drawing import (
    BORDER,
    BOUNDARY,
    CHOICE,
    CONTACT,
    DPI,
    FREE,
    FRONTIER_COLOR,
    OBSTACLE,
    PREDICTED,
    ROBOT,
    SCAN,
    SHADOW,
    TEXT,
    area_key,
    draw_arrow,
    draw_free_space,
    draw_frontiers,
    draw_map_border,
    draw_robot,
    draw_world,
    label,
    line_key,
    mark_key,
    new_figure,
    save,
    show_square,
)

ROSETTE = 0.04
"""Length at which a candidate of full speed is drawn [m]: half the spacing of the positions."""
TANGENT = 0.13
"""Length at which a predicted boundary is drawn [m]; it has none."""
COSTS = "viridis_r"
NEAREST_COST, FARTHEST_COST = 1.0, 100.0
"""Between these the cost above that of the best has a color of its own."""


class Drawn(NamedTuple):
    """What the picture holds, for whoever checks it: lines by kind of frontier, and the candidates of both panels."""

    cycle: Cycle
    frontiers: dict[int, LineCollection]
    n_predicted: int
    all_candidates: LineCollection
    survivors: LineCollection


def shown_cycle() -> Cycle:
    """A robot behind the second passage of `corridor`, on its way to the goal."""
    state = State(0.0, np.array([1.16, 1.72]), np.array([0.1, 0.5]), 0.0)
    return cycle_at(load_world("corridor"), Settings(), state)


def without_pruning(cycle: Cycle) -> Cycle:
    """A cycle like another one, with all candidates compared."""
    planner = replace(cycle.settings.planner, position_pruning=False, velocity_pruning=False)
    return cycle_at(cycle.world, replace(cycle.settings, planner=planner), cycle.state, cycle.before)


def draw(path: Path, dpi: int = DPI) -> Drawn:
    """Writes the picture."""
    cycle = shown_cycle()
    every = without_pruning(cycle)
    figure = new_figure(8.8)
    top, bottom = figure.subfigures(2, 1, height_ratios=(4.7, 4.3))
    upper, key = top.subplots(1, 2, width_ratios=(1.9, 1.0))
    frontiers = _draw_map(upper, cycle)
    _draw_key(key)
    left, right = bottom.subplots(1, 2)
    drawn = [_draw_candidates(axes, each) for axes, each in ((left, every), (right, cycle))]
    left.set_title(f"(b) all {len(every.plan.candidates.costs)} candidates")
    right.set_title(f"(c) the {len(cycle.plan.candidates.costs)} left by pruning, and the choice")
    _draw_choice(right, cycle)
    bottom.colorbar(
        ScalarMappable(drawn[0].norm, COSTS),
        ax=[left, right],
        orientation="horizontal",
        shrink=0.6,
        pad=0.02,
        aspect=40,
        ticks=[1, 3, 10, 30, 100],
        format="%g",
        label="a ray is a direction at 4 speeds; colour: cost above that of the best candidate, eq. (1)",
    )
    save(figure, path, dpi)
    return Drawn(cycle, frontiers, len(cycle.local_map.predicted), *drawn)


def _draw_map(axes: Axes, cycle: Cycle) -> dict[int, LineCollection]:
    """Fig. 2: the map with its symbols."""
    local_map = cycle.local_map
    _draw_scene(axes, cycle)
    frontiers = draw_frontiers(axes, local_map)
    _draw_scan(axes, cycle)
    _draw_predicted(axes, local_map)
    _name_predicted(axes, local_map)
    _draw_sight(axes, cycle)
    _name_frontiers(axes, local_map)
    axes.plot(*cycle.plan.positions.T, color=TEXT, linewidth=1.5, zorder=6)
    _draw_choice(axes, cycle)
    axes.set_title("(a) local map, simulated in corridor")
    return frontiers


def _draw_scene(axes: Axes, cycle: Cycle) -> None:
    draw_world(axes, cycle.world)
    draw_free_space(axes, cycle.local_map)
    draw_map_border(axes, cycle.local_map)
    draw_robot(axes, cycle.state.position, cycle.settings.robot.radius)
    show_square(axes, cycle.local_map.position, 1.2 * cycle.local_map.half_side)


def _draw_scan(axes: Axes, cycle: Cycle) -> None:
    scan = cycle.scan
    hit = np.isfinite(scan.ranges)
    angles = scan.angles[hit] + cycle.state.yaw
    points = cycle.state.position + scan.ranges[hit, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    axes.plot(*points.T, ".", color=SCAN, markersize=2.5, zorder=4)


def _draw_predicted(axes: Axes, local_map: LocalMap) -> None:
    for x, y, tx, ty in local_map.predicted:
        axes.plot(x, y, "o", color=PREDICTED, markersize=4.0, zorder=10)
        draw_arrow(axes, np.array([x, y]), np.array([x + TANGENT * tx, y + TANGENT * ty]), PREDICTED)


def _name_predicted(axes: Axes, local_map: LocalMap) -> None:
    """On the side of the obstacle."""
    for k, (x, y, tx, ty) in enumerate(local_map.predicted, start=1):
        origin, tangent, left = np.array([x, y]), np.array([tx, ty]), np.array([-ty, tx])
        side = -10.0 if local_map.contains(origin - 0.02 * tangent + 0.02 * left)[0] else 10.0
        label(axes, origin + 0.6 * TANGENT * tangent, f"$e_{k}$", PREDICTED, tuple(side * left))


def _name_frontiers(axes: Axes, local_map: LocalMap) -> None:
    for i, number in enumerate(np.unique(local_map.frontier_number), start=1):
        pieces = local_map.segments[local_map.frontier_number == number]
        piece = pieces[np.argmax(np.hypot(*(pieces[:, 2:] - pieces[:, :2]).T))]
        middle, (dx, dy) = 0.5 * (piece[:2] + piece[2:]), piece[2:] - piece[:2]
        kind = int(local_map.frontier_kind[local_map.frontier_number == number][0])
        away = 11.0 / np.hypot(dx, dy)
        label(axes, middle, f"$B_{i}$", FRONTIER_COLOR[kind], (dy * away, -dx * away))


def _draw_sight(axes: Axes, cycle: Cycle) -> None:
    """theta_sight at the choice: from its bearing to both open sides of its frontier."""
    local_map, aim = cycle.local_map, cycle.plan.aim - cycle.local_map.position
    open_side = local_map.open_side[_piece_of(local_map, cycle.plan.aim)]
    far = cycle.settings.local_map.sight_share * local_map.half_side
    right, left = (
        sight_angle(
            local_map.reach, aim[0], aim[1], bool(open_side[0]) and way == 0, bool(open_side[1]) and way == 1, far
        )
        for way in (0, 1)
    )
    bearing = np.arctan2(aim[1], aim[0])
    low, high = np.degrees([bearing - right, bearing + left])
    radius = 0.45 * local_map.half_side
    axes.add_patch(
        Wedge(tuple(local_map.position), radius, low, high, facecolor=CONTACT, alpha=0.35, edgecolor="none", zorder=2)
    )
    middle = np.radians(0.5 * (low + high))
    label(
        axes,
        local_map.position + radius * np.array([np.cos(middle), np.sin(middle)]),
        r"$\theta_{sight}$",
        "#9a6b00",
        (0.0, 8.0),
    )


def _piece_of(local_map: LocalMap, point: np.ndarray) -> int:
    """The straight piece of a frontier that a point (2,) on it lies on."""
    starts, steps = local_map.segments[:, :2], local_map.segments[:, 2:] - local_map.segments[:, :2]
    along = np.clip(((point - starts) * steps).sum(axis=1) / (steps**2).sum(axis=1), 0.0, 1.0)
    return int(np.argmin(np.hypot(*(starts + along[:, None] * steps - point).T)))


def _draw_candidates(axes: Axes, cycle: Cycle) -> LineCollection:
    """Fig. 3: a candidate is the part of a ray from its position that ends at its velocity and begins at the slower."""
    _draw_scene(axes, cycle)
    draw_frontiers(axes, cycle.local_map)
    _draw_predicted(axes, cycle.local_map)
    marks = candidate_marks(cycle.plan.candidates, cycle.settings)
    axes.add_collection(marks)
    return marks


def candidate_marks(candidates: Candidates, settings: Settings) -> LineCollection:
    """One short line a candidate, by its position, velocity and cost; a candidate at rest is a dot."""
    speed = np.hypot(*candidates.velocities.T)
    slower = np.maximum(speed - settings.robot.max_speed / settings.planner.n_speeds, 0.0)
    begins = np.divide(slower, speed, where=speed > 0.0, out=np.zeros_like(speed))[:, None] * candidates.velocities
    scale = ROSETTE / settings.robot.max_speed
    lines = candidates.positions[:, None] + scale * np.stack([begins, candidates.velocities], axis=1)
    above = candidates.costs - candidates.costs.min()
    order = np.argsort(-above, kind="stable")
    marks = LineCollection(
        lines[order], cmap=COSTS, norm=LogNorm(NEAREST_COST, FARTHEST_COST), linewidth=1.8, capstyle="round", zorder=9
    )
    marks.set_array(np.maximum(above, NEAREST_COST)[order])
    return marks


def _draw_choice(axes: Axes, cycle: Cycle) -> None:
    plan = cycle.plan
    axes.plot(*plan.aim, "o", color=CHOICE, markersize=5.0, zorder=11)
    draw_arrow(axes, plan.aim, plan.aim + 0.12 * plan.aim_velocity, CHOICE, 2.0, zorder=11)


def _draw_key(axes: Axes) -> None:
    axes.axis("off")
    entries: list[Any] = [
        area_key("obstacles (unknown to the planner)", OBSTACLE),
        mark_key("scan", SCAN, "."),
        mark_key("robot", "white", "o", 10.0, ROBOT),
        area_key(r"free space $\mathcal{F}$ of its centre", FREE),
        line_key(r"observed boundary $\partial\mathcal{O}_j$, grown", BOUNDARY),
        line_key("frontier $B_i$: shadow edge", SHADOW, 3.0),
        line_key("frontier $B_i$: run of the map border", BORDER, 3.0),
        line_key("predicted boundary $e_i$, its tangent", PREDICTED, marker="o"),
        area_key(r"$\theta_{sight}$ at the choice", "#f9dd99"),
        line_key("choice $q_s$: $p_s$ and $v_s$", CHOICE, marker="o"),
        line_key("reference $q_{spl}$", TEXT, 1.5),
    ]
    axes.legend(handles=entries, loc="center left", labelspacing=0.9, borderaxespad=0.0)
