"""maneuvers.png: what the controller makes of a plan that meets an observed boundary. Paper: III-B, Alg. 3, Fig. 4."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from collplan_core.command import BOUNDARY_FOLLOWING, FLOW_THROUGH, FREE_SPACE
from collplan_core.control.follow import set_course
from collplan_core.control.memory import ManeuverCourse
from collplan_core.parameters import Settings
from collplan_core.state import State
from collplan_core.worlds import load_world
from cycles import Cycle, cycle_at
from drawing import (
    BORDER,
    BOUNDARY,
    CHOICE,
    CONTACT,
    DPI,
    FAINT,
    FREE,
    FREE_SPACE_REFERENCE,
    OBSTACLE,
    PREDICTED,
    SHADOW,
    area_key,
    draw_arrow,
    draw_free_space,
    draw_frontiers,
    draw_robot,
    draw_world,
    label,
    line_key,
    mark_key,
    new_figure,
    save,
    show,
)

AROUND = 0.24
"""Shown around the references and the robot [m]."""
SPEED = 0.18
"""A velocity of 1 m/s is drawn so long [m]."""
SCENES = {
    FREE_SPACE: ((1.10, 1.45), (0.0, 0.6)),
    BOUNDARY_FOLLOWING: ((1.85, 1.65), (-0.9, 0.0)),
    FLOW_THROUGH: ((0.96, 1.69), (0.68, -0.01)),
}
"""In `corridor`, where the robot is [m] and how it moves [m/s], such that its plan needs each of the maneuvers."""
TITLES = {
    FREE_SPACE: r"(a) free space: $q_{spl}$",
    BOUNDARY_FOLLOWING: r"(b) boundary following: $q_{bound}$",
    FLOW_THROUGH: r"(c) flow through: $q_{flow}$",
}


class Drawn(NamedTuple):
    """One panel: the cycle, and the maneuver for its plan."""

    cycle: Cycle
    course: ManeuverCourse


def draw(path: Path, dpi: int = DPI) -> list[Drawn]:
    """Writes the picture."""
    figure = new_figure(3.55)
    drawn = [_planned(*scene) for scene in SCENES.values()]
    for axes, each in zip(figure.subplots(1, len(drawn)), drawn, strict=True):
        _draw_panel(axes, each)
    figure.legend(handles=_key(), loc="outside lower center", ncols=4, columnspacing=1.4, fontsize=8.0)
    save(figure, path, dpi)
    return drawn


def _planned(position: tuple[float, float], velocity: tuple[float, float]) -> Drawn:
    state = State(0.0, np.array(position), np.array(velocity), 0.0)
    cycle = cycle_at(load_world("corridor"), Settings(), state)
    return Drawn(cycle, set_course(cycle.plan, cycle.local_map, cycle.settings))


def _draw_panel(axes: Axes, drawn: Drawn) -> None:
    cycle, course = drawn
    plan, local_map = cycle.plan, cycle.local_map
    draw_world(axes, cycle.world)
    draw_free_space(axes, local_map)
    draw_frontiers(axes, local_map)
    draw_robot(axes, cycle.state.position, cycle.settings.robot.radius)
    draw_arrow(axes, cycle.state.position, cycle.state.position + SPEED * cycle.state.velocity, FAINT)
    axes.plot(*plan.positions.T, color=FREE_SPACE_REFERENCE, linewidth=1.6, zorder=9)
    axes.plot(*plan.aim, "o", color=CHOICE, markersize=4.5, zorder=10)
    draw_arrow(axes, plan.aim, plan.aim + SPEED * plan.aim_velocity, CHOICE)
    if course.contact_path is not None:
        _draw_maneuver(axes, drawn)
    axes.set_title(TITLES[course.maneuver], fontsize=9.5)
    _show(axes, np.vstack([plan.positions, plan.aim + SPEED * plan.aim_velocity]))


def _draw_maneuver(axes: Axes, drawn: Drawn) -> None:
    course, delta = drawn.course, drawn.cycle.settings.controller.switch_distance
    assert course.contact_path is not None
    axes.plot(*course.contact_path.T, color=PREDICTED, linewidth=2.6, linestyle=(0, (3, 1.2)), zorder=9.5)
    for point, name, color in ((course.contact_point, "$p_c$", CONTACT), (course.release_point, "$p_d$", PREDICTED)):
        assert point is not None
        axes.add_patch(Circle(tuple(point), delta, fill=False, edgecolor=color, linestyle=":", linewidth=1.2, zorder=8))
        axes.plot(
            *point, "X" if name == "$p_c$" else "D", color=color, markeredgecolor="black", markersize=7, zorder=11
        )
        label(axes, point, name, "black", (-12.0, 6.0))


def _show(axes: Axes, points: np.ndarray) -> None:
    """A square around the points (n, 2)."""
    center = 0.5 * (points.min(axis=0) + points.max(axis=0))
    half = 0.5 * float((points.max(axis=0) - points.min(axis=0)).max()) + AROUND
    show(axes, (*(center - half), *(center + half)))


def _key() -> list:
    return [
        area_key("obstacles", OBSTACLE),
        area_key(r"free space $\mathcal{F}$", FREE),
        line_key("observed boundary", BOUNDARY),
        line_key("frontier: shadow edge", SHADOW, 3.0),
        line_key("frontier: map border", BORDER, 3.0),
        line_key("velocity now", FAINT),
        line_key("choice $p_s$, $v_s$", CHOICE, marker="o"),
        line_key(r"$q_{spl}$", FREE_SPACE_REFERENCE, 1.6),
        line_key(r"$q_{bound}$, $q_{flow}$", PREDICTED, 2.6, (0, (3, 1.2))),
        mark_key(r"$p_c$: engages within $\delta$", CONTACT, "X", 7.0, "black"),
        mark_key(r"$p_d$: disengages within $\delta$", PREDICTED, "D", 6.0, "black"),
    ]
