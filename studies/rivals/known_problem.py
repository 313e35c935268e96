"""The problem that every rival solves: a whole world with dynamics and costs of one of the project's own strategies."""

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.plan import Plan, timed_path
from collplan_core.time_to_goal_planner.dynamics import Motion
from collplan_core.time_to_goal_planner.full_plan import sample_trajectory
from collplan_core.time_to_goal_planner.known_map import given_map
from collplan_core.time_to_goal_planner.model import Problem, problem_of
from collplan_core.time_to_goal_planner.plan_cycle import contacts_of
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths
from collplan_core.worlds import World


def known_problem(world: World, settings: Settings) -> Problem:
    """The problem of a whole world from its start to its goal, with contacts and costs of `planner.strategy`."""
    remembered = given_map(world, settings).remembered
    assert remembered is not None
    paths = shortest_paths(remembered.field, np.asarray(world.goal), np.asarray(world.start), settings)
    return problem_of(remembered.field, remembered.free, paths, settings)


def plan_along(problem: Problem, initial: Motion, commands: np.ndarray, stamp: float, radius: float) -> Plan:
    """The plan of a disc of a radius [m] that commands (n, 2) make from `stamp` [s], one a control interval [m/s]."""
    rows, touched = sample_trajectory(problem, initial, commands, radius)
    times, positions, velocities = (np.ascontiguousarray(each) for each in (rows[:, 0], rows[:, 1:3], rows[:, 3:]))
    return timed_path(stamp, stamp + times, positions, velocities, contacts=contacts_of(stamp, touched))
