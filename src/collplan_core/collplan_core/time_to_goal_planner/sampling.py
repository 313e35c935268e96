"""A whole plan in full: where the disc is when, and every contact."""

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import INFERRED, OBSERVED
from collplan_core.time_to_goal_planner.control_interval import is_there
from collplan_core.time_to_goal_planner.dynamics import glided, step
from collplan_core.time_to_goal_planner.full_plan import near_at
from collplan_core.time_to_goal_planner.model import KNOT_STEPS, STEP, Law, Scene

SHORTEST = 0.01
"""A contact nearer to the beginning or end of a step than this share of it is put there."""


@njit
def in_full(scene: Scene, law: Law, begin: np.ndarray, commands: np.ndarray, n: int, radius: float,
            ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The rollout of commands[:n] from begin (x, y, vx, vy), to the goal where it gets there.

    Returns:
        rows (k, 5): time since the beginning [s], x, y, vx, vy, also at the moment of every contact;
        contacts (c, 5): time, point touched x, y, velocity after vx, vy; those with inferred solid are left out.
    """
    clearance, source, grid = scene.clearance, scene.source, scene.grid
    most = n * KNOT_STEPS
    rows, contacts = np.empty((2 * most + 1, 5)), np.empty((most, 5))
    x, y, vx, vy = begin
    near = near_at(scene, x, y)
    rows[0, 0], rows[0, 1], rows[0, 2], rows[0, 3], rows[0, 4] = 0.0, x, y, vx, vy
    count, touched = 1, 0
    for k in range(most):
        ux, uy = commands[k // KNOT_STEPS]
        fx, fy, _, _ = glided(x, y, vx, vy, ux, uy, law)
        bx, by = x, y
        x, y, vx, vy, near, kind, _, share, nx, ny = step(clearance, source, grid, law, x, y, vx, vy, near, ux, uy)
        time = k * STEP
        if kind in (OBSERVED, INFERRED):
            cx, cy = bx + share * (fx - bx), by + share * (fy - by)
            if SHORTEST < share < 1.0 - SHORTEST:
                rows[count, 0], rows[count, 1], rows[count, 2] = time + share * STEP, cx, cy
                rows[count, 3], rows[count, 4] = vx, vy
                count += 1
            if kind == OBSERVED:
                contacts[touched, 0] = time + share * STEP
                contacts[touched, 1], contacts[touched, 2] = cx - radius * nx, cy - radius * ny
                contacts[touched, 3], contacts[touched, 4] = vx, vy
                touched += 1
        rows[count, 0], rows[count, 1], rows[count, 2] = time + STEP, x, y
        rows[count, 3], rows[count, 4] = vx, vy
        count += 1
        if is_there(scene.goal, x, y):
            break
    return rows[:count], contacts[:touched]
