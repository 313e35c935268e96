"""Whether the robot could still brake within what it has seen."""

import math

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at
from collplan_core.time_to_goal_planner.model import STEP, Law, Scene

UNSTOPPABLE = 100.0
"""Added to J of a plan that fails the stop test [s]."""
BRAKING_SHARE = 0.9
"""Share of the largest acceleration that braking counts on."""
SWERVES = (0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2)
"""Bearings off straight back in which the first half of the braking pushes [rad]."""


@njit
def _is_free(scene: Scene, x: float, y: float) -> bool:
    nx, ny = scene.free.shape
    i, j = (
        int(math.floor((x - scene.grid.ox) / scene.grid.spacing + 0.5)),
        int(math.floor((y - scene.grid.oy) / scene.grid.spacing + 0.5)),
    )
    return 0 <= i < nx and 0 <= j < ny and scene.free[i, j]


@njit
def _stops(scene: Scene, law: Law, x: float, y: float, vx: float, vy: float, swerve: float) -> bool:
    speed = math.hypot(vx, vy)
    brake = BRAKING_SHARE * law.max_acceleration
    if speed > 1e-9:
        c, s = -math.cos(swerve) / speed, -math.sin(swerve) / speed
        ax, ay = brake * (c * vx - s * vy), brake * (s * vx + c * vy)
        first = max(int(0.5 * speed / brake / STEP), 1)
        for k in range(400):
            if k >= first:
                speed = math.hypot(vx, vy)
                if speed <= brake * STEP:
                    break
                ax, ay = -brake * vx / speed, -brake * vy / speed
            x, y = x + vx * STEP + 0.5 * ax * STEP * STEP, y + vy * STEP + 0.5 * ay * STEP * STEP
            vx, vy = vx + ax * STEP, vy + ay * STEP
            if clearance_at(scene.clearance, scene.grid.ox, scene.grid.oy, scene.grid.spacing, x, y) < 0.0:
                return False
    return _is_free(scene, x, y)


@njit
def admits_stop(scene: Scene, law: Law, x: float, y: float, vx: float, vy: float) -> bool:
    """Whether some two-phase braking from here touches nothing and ends where the disc was seen to be free."""
    for swerve in SWERVES:  # noqa: SIM110 (numba has no generators)
        if _stops(scene, law, x, y, vx, vy, swerve):
            return True
    return False
