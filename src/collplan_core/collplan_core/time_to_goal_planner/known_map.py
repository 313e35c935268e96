"""Planning with a map given beforehand, for comparison with a planner that has to discover it."""

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.time_to_goal_planner.boundary_memory.update import known_boundaries
from collplan_core.time_to_goal_planner.plan_cycle import RolloutMemory
from collplan_core.worlds import World, world_segments

CIRCLE_SIDES = 64


def given_map(world: World, settings: Settings) -> RolloutMemory:
    """A first memory that holds the whole world and merges no scan. Never for a robot: the world is the truth."""
    x0, y0, x1, y1 = world.bounds
    walls = np.vstack([world_segments(world), *(_sides(*circle) for circle in world.circles)])
    center = np.array([0.5 * (x0 + x1), 0.5 * (y0 + y1)])
    return RolloutMemory(remembered=known_boundaries(walls, center, settings.robot, settings.remembered), known=True)


def _sides(x: float, y: float, radius: float) -> np.ndarray:
    """(64, 4) the sides of a polygon around the circle's centre, half in and half out of it."""
    angles = 2.0 * np.pi * np.arange(CIRCLE_SIDES) / CIRCLE_SIDES
    mean = radius * (1.0 + (np.pi / CIRCLE_SIDES) ** 2 / 4.0)
    corners = np.column_stack([x + mean * np.cos(angles), y + mean * np.sin(angles)])
    return np.hstack([corners, np.roll(corners, -1, axis=0)])
