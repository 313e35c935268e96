"""Model of one cycle's rollouts, as plain tuples that compiled code takes."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.goal import AT_REST
from collplan_core.parameters import Settings
from collplan_core.reflection import Ring, believed_ring
from collplan_core.strategies import BY_SPEED, FREE, REFLECTS, TIME_TO_GOAL
from collplan_core.time_to_goal_planner.boundary_memory.clearance import ClearanceField, Grid
from collplan_core.time_to_goal_planner.shortest_paths.record import PathLookup, ShortestPaths
from collplan_core.velocity_bounds import VelocityBounds, velocity_bounds
from collplan_core.velocity_law import VelocityLaw, velocity_law

MAP_PERIOD = 0.05
"""Time between two plans where planner.map_period is 0 [s]."""
STEP = 0.025
"""Length of a rollout's step [s]."""
INTERVAL_STEPS = 2
"""Steps for which one command holds."""
CONTROL_INTERVAL = INTERVAL_STEPS * STEP
"""Time for which one command holds [s]."""
IMPACT_SPEED = 0.08
"""A contact slower than this slides and costs nothing [m/s]."""
TURNING_OFF = 0.35
"""Time left to plan anew and turn off or slow down, where what was to stand by then does not [s]."""
AVERSE_COSTS = 0.5, 2.0
"""avoid, stop_guarantee: cost of any contact [s], and by its speed into the boundary [s per m/s]."""
INFERRED_COST = 0.3
"""bounce, tolerate: cost of running into inferred solid, by the speed into it [s per m/s]."""
MARGIN_COST = 2500.0
"""Cost of a place within the margin, by time and by the square of how far within [1/m^2]."""
ARRIVAL_SHARE = 0.7
"""Rollouts end within this share of goal_tolerance, because one that grazes the edge may miss it."""
GRAZE_COST = 0.5
"""Cost of an arrival that passes the goal at goal_tolerance, by the square of the distance: it may miss [s]."""
EXCLUDED, EXCLUDED_BY_SPEED = 100.0, 1000.0
"""Cost of a contact above limits.impact_speed [s], and of how far above it is [s per m/s]: all else weighs less."""


class RobotModel(NamedTuple):
    """Motion model of the robot: its wheels, and the ring that contacts are computed with."""

    wheels: VelocityLaw
    ring: Ring
    stood_by: float  # from this time of a plan on, what is pending counts as standing [s]


class ContactCosts(NamedTuple):
    """Costs of contacts and near misses [s]."""

    fixed: float  # fixed, by_speed: cost of a contact, and by its normal speed [s per m/s]
    by_speed: float
    limit: float
    """Normal speed above which a contact is excluded [m/s]: taken only where none is below it, then the least."""
    inferred_fixed: float
    inferred_by_speed: float
    """inferred_fixed, inferred_by_speed: cost of a contact with inferred solid, and by its normal speed [s per m/s]."""
    near: float  # cost, by time, of the square by which the clearance is below the margin [1/m^2]
    margin: float  # [m]


class GoalDisc(NamedTuple):
    """The disc in which rollouts end."""

    x: float  # x, y, tolerance: centre and radius [m]
    y: float
    tolerance: float
    longest_within: float  # no path from within the disc to its centre is longer [m]
    graze_cost: float  # cost of an arrival, by the square of the distance at which its line passes the centre [s/m^2]
    rest_speed: float  # largest speed of an arrival [m/s]; inf where the goal may be passed


class Constants(NamedTuple):
    """The scalars of a problem, which every step of a rollout needs."""

    grid: Grid
    goal: GoalDisc
    model: RobotModel
    costs: ContactCosts
    bounds: VelocityBounds


class Problem(NamedTuple):
    """All that a cycle's rollouts have in common.

    What runs for every step takes arrays and constants one by one: counting the references of a tuple of arrays costs
    more there than the step. A tuple of scalars costs nothing.
    """

    clearance: np.ndarray  # clearance, source: (nx, ny) as in ClearanceField, on the nodes of `constants.grid`
    source: np.ndarray
    free: np.ndarray  # (nx, ny) where the disc's centre was seen to be free
    paths: PathLookup  # shortest paths to the goal
    constants: Constants
    stop_test: bool  # whether the robot must be able to brake within what it has seen
    movers: np.ndarray  # (k, 6) discs of `mover_cost` when the plan begins
    trails: np.ndarray  # (h, 4) trails of `mover_cost`


def robot_model(settings: Settings) -> RobotModel:
    """The robot as the chosen strategy takes it to be."""
    ring, reflects = believed_ring(settings), TIME_TO_GOAL[settings.planner.strategy].contact_law == REFLECTS
    wheels = velocity_law(settings.robot, STEP)
    stood_by = settings.movers.standing_time + TURNING_OFF
    return RobotModel(wheels, ring if reflects else ring._replace(restitution=0.0), stood_by)


def contact_costs(settings: Settings) -> ContactCosts:
    """Returns the costs of contacts under the chosen strategy."""
    p, tolerance = settings.time_to_goal, TIME_TO_GOAL[settings.planner.strategy].contact_tolerance
    if tolerance == BY_SPEED:
        observed, inferred, margin = (0.0, p.hit_cost), (0.0, INFERRED_COST), p.tolerant_distance
    elif tolerance == FREE:
        observed, inferred, margin = (0.0, 0.0), (0.0, INFERRED_COST), p.tolerant_distance
    else:
        observed, inferred, margin = AVERSE_COSTS, AVERSE_COSTS, p.averse_distance
    return ContactCosts(*observed, settings.limits.impact_speed, *inferred, MARGIN_COST, margin)


def problem_of(
    field: ClearanceField,
    free: np.ndarray,
    paths: ShortestPaths,
    settings: Settings,
    yaw: float = 0.0,
    movers: tuple[np.ndarray, np.ndarray] = (np.zeros((0, 6)), np.zeros((0, 4))),
) -> Problem:
    """The problem of a cycle: boundaries, where the disc was seen to be free (nx, ny), paths, robot and strategy.

    The robot holds its yaw [rad]. `movers` are the discs (k, 6) and the trails (h, 4) of `mover_cost`.
    """
    tolerance = ARRIVAL_SHARE * paths.tolerance
    stops = settings.planner.stop_at_goal
    graze_cost, rest_speed = (0.0, AT_REST) if stops else (GRAZE_COST / paths.tolerance**2, math.inf)
    x, y = (float(value) for value in paths.goal)
    goal = GoalDisc(x, y, tolerance, paths.longest_within(tolerance), graze_cost, rest_speed)
    bounds = velocity_bounds(settings.robot, yaw)
    constants = Constants(field.grid, goal, robot_model(settings), contact_costs(settings), bounds)
    stop_test = TIME_TO_GOAL[settings.planner.strategy].stop_test
    return Problem(field.clearance, field.source, free, paths.lookup(tolerance), constants, stop_test, *movers)
