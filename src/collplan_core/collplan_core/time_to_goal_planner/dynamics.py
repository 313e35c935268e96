"""One step of the robot's law, with the first contact in it."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.reflection import reflect
from collplan_core.time_to_goal_planner.boundary_memory.clearance import (
    INFERRED,
    OBSERVED,
    clearance_at,
    normal_at,
    source_at,
)
from collplan_core.time_to_goal_planner.model import IMPACT_SPEED, STEP, Grid, Law, Price

NO_CONTACT, SLIDES = 0, 3
"""Kinds of contact beside OBSERVED and INFERRED."""


@njit
def driven(vx: float, vy: float, ux: float, uy: float, duration: float, law: Law) -> tuple[float, float]:
    """Velocity after `duration` [s] of dv/dt = sat((u - v) / lag): at full acceleration, then as a first-order lag."""
    dx, dy = ux - vx, uy - vy
    gap2 = dx * dx + dy * dy
    linear = law.max_acceleration * law.lag
    if gap2 <= linear * linear:
        share = 1.0 - (law.decay if duration == STEP else math.exp(-duration / law.lag))
    else:
        gap = math.sqrt(gap2)
        saturated = (gap - linear) / law.max_acceleration
        if saturated >= duration:
            share = law.max_acceleration * duration / gap
        else:
            share = 1.0 - linear * math.exp(-(duration - saturated) / law.lag) / gap
    return vx + share * dx, vy + share * dy


@njit
def glided(x: float, y: float, vx: float, vy: float, ux: float, uy: float, law: Law,
           ) -> tuple[float, float, float, float]:  # fmt: skip
    """x, y, vx, vy after a STEP under command u where nothing is in the way."""
    wx, wy = driven(vx, vy, ux, uy, STEP, law)
    return x + 0.5 * (vx + wx) * STEP, y + 0.5 * (vy + wy) * STEP, wx, wy


@njit
def step(clearance: np.ndarray, source: np.ndarray, grid: Grid, law: Law, x: float, y: float, vx: float, vy: float,
         near: float, ux: float, uy: float,
         ) -> tuple[float, float, float, float, float, int, float, float, float, float]:  # fmt: skip
    """STEP under command u, from a place whose clearance is at least `near`.

    Returns:
        x, y, vx, vy, what the clearance there is at least, kind of contact, speed into it, its share of the step, its
        normal x, y.
    """
    px, py, wx, wy = glided(x, y, vx, vy, ux, uy, law)
    # no component of a step is longer than the step
    bound = near - abs(px - x) - abs(py - y)
    if bound > 0.0:
        return px, py, wx, wy, bound, NO_CONTACT, 0.0, 0.0, 0.0, 0.0
    after = clearance_at(clearance, grid.ox, grid.oy, grid.spacing, px, py)
    if after >= 0.0:
        return px, py, wx, wy, after, NO_CONTACT, 0.0, 0.0, 0.0, 0.0
    return _touch(clearance, source, grid, law, x, y, vx, vy, px, py, wx, wy, after, ux, uy)


@njit
def _touch(clearance: np.ndarray, source: np.ndarray, grid: Grid, law: Law, x: float, y: float, vx: float, vy: float,
           px: float, py: float, wx: float, wy: float, after: float, ux: float, uy: float,
           ) -> tuple[float, float, float, float, float, int, float, float, float, float]:  # fmt: skip
    """The rest of a step that ends inside a boundary: up to the contact, off it, and on."""
    before = clearance_at(clearance, grid.ox, grid.oy, grid.spacing, x, y)
    share = 0.0
    if before > 1e-4:
        share = before / (before - after)
        # one step of false position: the clearance bends at corners
        middle = clearance_at(clearance, grid.ox, grid.oy, grid.spacing, x + share * (px - x), y + share * (py - y))
        if middle > 0.0:
            share += (1.0 - share) * middle / (middle - after)
        else:
            share *= before / (before - middle)
    cx, cy = x + share * (px - x), y + share * (py - y)
    nx, ny = normal_at(clearance, grid.ox, grid.oy, grid.spacing, cx, cy)
    sx, sy = vx + share * (wx - vx), vy + share * (wy - vy)
    into = -(sx * nx + sy * ny)
    kind = SLIDES
    if into > IMPACT_SPEED:
        kind = OBSERVED if source_at(source, grid.ox, grid.oy, grid.spacing, cx, cy) != INFERRED else INFERRED
        restitution = law.restitution if kind == OBSERVED else 0.0
        sx, sy = reflect(sx, sy, nx, ny, restitution, law.retention)
    elif into > 0.0:
        sx, sy = sx + into * nx, sy + into * ny
    rest = (1.0 - share) * STEP
    wx, wy = driven(sx, sy, ux, uy, rest, law)
    pressed = -(wx * nx + wy * ny)
    if kind == SLIDES and pressed > 0.0:
        wx, wy = wx + pressed * nx, wy + pressed * ny
    px, py = cx + 0.5 * (sx + wx) * rest, cy + 0.5 * (sy + wy) * rest
    after = clearance_at(clearance, grid.ox, grid.oy, grid.spacing, px, py)
    if after < 0.0:
        px, py = px - after * nx, py - after * ny
        after = 0.0
    return px, py, wx, wy, after, kind, into, share, nx, ny


@njit
def contact_cost(price: Price, kind: int, into: float) -> float:
    """What a contact costs [s]."""
    if kind == OBSERVED:
        return price.fixed + price.by_speed * into + (price.over if into > price.limit else 0.0)
    if kind == INFERRED:
        return price.inferred_fixed + price.inferred_by_speed * into
    return 0.0


@njit
def clearance_cost(clearance: np.ndarray, grid: Grid, price: Price, x: float, y: float, px: float, py: float,
                   speed: float) -> float:  # fmt: skip
    """What a chord from (x, y) to (px, py) costs for being grazed when it is driven a little beside [s]."""
    d = price.distance
    length = math.sqrt((px - x) * (px - x) + (py - y) * (py - y))
    if length < 1e-9:
        return 0.0
    dx, dy = (px - x) / length, (py - y) / length
    cost = 0.0
    for side in (-1.0, 1.0):
        ex, ey = -side * d * dy, side * d * dx
        qx, qy = px + ex, py + ey
        if clearance_at(clearance, grid.ox, grid.oy, grid.spacing, qx, qy) >= 0.0:
            continue
        if clearance_at(clearance, grid.ox, grid.oy, grid.spacing, x + ex, y + ey) < 0.0:
            continue
        nx, ny = normal_at(clearance, grid.ox, grid.oy, grid.spacing, qx, qy)
        square = -(dx * nx + dy * ny)
        if square > 0.3:
            cost += price.clearance * square * speed
    return cost
