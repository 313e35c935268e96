"""Full plans: a command for each control interval up to the goal, with the resulting motion and cost."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import ON_THE_WAY, end_cost
from collplan_core.time_to_goal_planner.control_interval import roll_interval
from collplan_core.time_to_goal_planner.dynamics import Motion
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, INTERVAL_STEPS, Problem
from collplan_core.time_to_goal_planner.stopping import STOP_TEST_STEPS, stop_cost

STOP_TEST_INTERVAL = STOP_TEST_STEPS // INTERVAL_STEPS


class FullPlan(NamedTuple):
    """Commands and what they lead to; there is room for more than the n control intervals in use.

    Attributes:
        commands: (m, 2) [m/s].
        states: (m + 1, 4) x, y, vx, vy before each interval and after the last.
        costs: (m + 1,) cost up to each of the states, its time left out [s].
        n: intervals in use.
        cost: cost of the plan, its time included [s].
    """

    commands: np.ndarray
    states: np.ndarray
    costs: np.ndarray
    n: int
    cost: float


@njit
def clip(ux: float, uy: float, max_speed: float) -> tuple[float, float]:
    """A velocity shortened to max_speed."""
    speed = math.sqrt(ux * ux + uy * uy)
    return (ux * max_speed / speed, uy * max_speed / speed) if speed > max_speed else (ux, uy)


@njit
def roll(problem: Problem, initial: Motion, commands: np.ndarray, n: int) -> FullPlan:
    """The plan that commands (m, 2) up to number n make, or as many of them as lead to the goal."""
    clearance, source, constants = problem.clearance, problem.source, problem.constants
    states, costs = np.zeros((len(commands) + 1, 4)), np.zeros(len(commands) + 1)
    motion = initial
    states[0, 0], states[0, 1], states[0, 2], states[0, 3] = motion.x, motion.y, motion.vx, motion.vy
    for k in range(n):
        motion, cost, arrival = roll_interval(clearance, source, constants, motion, commands[k, 0], commands[k, 1])
        states[k + 1, 0], states[k + 1, 1] = motion.x, motion.y
        states[k + 1, 2], states[k + 1, 3] = motion.vx, motion.vy
        costs[k + 1] = costs[k] + cost
        if problem.stop_test and k + 1 == STOP_TEST_INTERVAL:
            costs[k + 1] += stop_cost(problem, motion)
        if arrival != ON_THE_WAY:
            return FullPlan(commands, states, costs, k + 1, k * CONTROL_INTERVAL + arrival + costs[k + 1])
    return FullPlan(commands, states, costs, n, n * CONTROL_INTERVAL + costs[n] + end_cost(problem, motion))


def braking(problem: Problem, initial: Motion) -> FullPlan:
    """The plan that commands rest, whatever it is charged for."""
    model = problem.constants.model
    n = round(2.0 * model.max_speed / model.wheels.max_acceleration / CONTROL_INTERVAL) + 1
    return roll(problem._replace(stop_test=False), initial, np.zeros((n, 2)), n)
