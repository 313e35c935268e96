"""What a rollout is computed with, as plain tuples that compiled code takes."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.strategies import BY_SPEED, FREE, REFLECTS, contact_terms
from collplan_core.time_to_goal_planner.boundary_memory.clearance import ClearanceField
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths

STEP = 0.025
"""Of a rollout [s]."""
KNOT_STEPS = 2
"""Steps for which one command holds."""
KNOT = KNOT_STEPS * STEP
"""Time for which one command holds [s]."""
SHORTEST_LAG = 1e-3
"""A velocity loop without any lag is taken for this one [s]."""
IMPACT_SPEED = 0.08
"""A contact slower than this slides and costs nothing [m/s]."""


class Law(NamedTuple):
    """The robot's law: dv/dt = sat((u - v) / lag), and what a boundary makes of its velocity."""

    max_speed: float
    max_acceleration: float
    lag: float
    restitution: float
    retention: float
    decay: float
    """Share of a small difference to the command that is left after a STEP."""


class Price(NamedTuple):
    """What a contact costs [s]: fixed + by_speed * speed into it, + over where that is above the limit."""

    fixed: float
    by_speed: float
    over: float
    limit: float
    inferred_fixed: float
    inferred_by_speed: float
    clearance: float
    distance: float


class Grid(NamedTuple):
    """Where the nodes of the clearance field are."""

    ox: float
    oy: float
    spacing: float


class Goal(NamedTuple):
    """Where the rollouts end."""

    x: float
    y: float
    tolerance: float
    graze: float
    """Cost of an arrival by the square of the distance at which its line passes the goal [s/m^2]."""


class Scene(NamedTuple):
    """Clearance field, where the disc was seen to be free, shortest paths and goal.

    What runs for every step takes the arrays one by one: counting the references of a tuple of arrays costs more there
    than the step.
    """

    clearance: np.ndarray
    source: np.ndarray
    free: np.ndarray
    grid: Grid
    goal: Goal
    waypoint: np.ndarray
    waypoints: np.ndarray
    onward: np.ndarray
    remaining: np.ndarray
    turning: np.ndarray
    gx: float
    gy: float
    cell: float


def law_of(settings: Settings) -> Law:
    """The robot's law as the chosen strategy believes it."""
    reflects = contact_terms(settings).contact_law == REFLECTS
    robot = settings.robot
    lag = max(robot.velocity_lag, SHORTEST_LAG)
    return Law(
        robot.max_speed, robot.max_acceleration, lag,
        settings.rebound.restitution if reflects else 0.0, settings.rebound.tangential_retention,
        math.exp(-STEP / lag),
    )  # fmt: skip


def price_of(settings: Settings) -> Price:
    """The prices of the chosen strategy."""
    p, tolerance = settings.time_to_goal, contact_terms(settings).contact_tolerance
    if tolerance == BY_SPEED:
        return Price(0.0, p.hit_cost, p.limit_cost, p.speed_limit, 0.0, p.inferred_cost, p.clearance_cost,
                     p.tolerant_distance)  # fmt: skip
    if tolerance == FREE:
        return Price(0.0, 0.0, 0.0, p.speed_limit, 0.0, p.inferred_cost, p.clearance_cost, p.tolerant_distance)
    return Price(p.averse_cost, p.averse_speed_cost, 0.0, p.speed_limit, p.averse_cost, p.averse_speed_cost,
                 p.clearance_cost, p.averse_distance)  # fmt: skip


def scene_of(field: ClearanceField, free: np.ndarray, paths: ShortestPaths, settings: Settings) -> Scene:
    """Field, where the disc was seen to be free (nx, ny), and paths in one tuple."""
    grid = Grid(float(field.origin[0]), float(field.origin[1]), field.spacing)
    p = settings.time_to_goal
    goal = Goal(
        float(paths.goal[0]), float(paths.goal[1]), p.arrival_share * paths.tolerance,
        p.graze_cost / paths.tolerance**2,
    )  # fmt: skip
    return Scene(
        field.clearance, field.source, free, grid, goal,
        paths.waypoint, paths.waypoints, paths.onward, paths.remaining, paths.turning,
        float(paths.origin[0]), float(paths.origin[1]), paths.spacing,
    )  # fmt: skip
