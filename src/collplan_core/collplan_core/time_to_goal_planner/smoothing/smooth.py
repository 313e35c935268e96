"""A whole plan made smooth: iterated passes over its knots, then the commands that follow them."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import is_there
from collplan_core.time_to_goal_planner.boundary_memory.clearance import OBSERVED
from collplan_core.time_to_goal_planner.dynamics import motion_at
from collplan_core.time_to_goal_planner.full_plan import FullPlan, roll
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, Problem
from collplan_core.time_to_goal_planner.sampling import sample_trajectory
from collplan_core.time_to_goal_planner.smoothing.backward import backward, empty_models
from collplan_core.time_to_goal_planner.smoothing.commands import commands_along
from collplan_core.time_to_goal_planner.smoothing.cost import limits_of
from collplan_core.time_to_goal_planner.smoothing.forward import Course, forward
from collplan_core.time_to_goal_planner.smoothing.knots import (
    MOST_PHASES,
    SHORTEST_PHASE,
    Knots,
    knots_of,
    margins_of,
    tracking_gains,
)

SHORTEST = 0.3
"""What is left of a plan is smoothed if it is at least so long [s]."""
MOST_PASSES, MOST_SHARES = 40, 6
"""Backward passes at most, and shares of what each asks for that are tried."""
NEXT_SHARE = 0.4
"""Factor from one share to the next."""
SETTLED = 3e-4
"""Passes end when one gains less than this [s]."""
DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-4, 1e-6, 10.0
"""Damping of the first pass, the least, and that beyond which passes end [s^5/m^2]."""
LESS_DAMPING, MORE_DAMPING = 0.3, 10.0
"""Factors on the damping after a pass that lowered the cost and one that did not."""


@njit
def smoothed(problem: Problem, plan: FullPlan) -> FullPlan:
    """The plan with smooth knots followed from where they can be; itself where there are none, it may cost more.

    Knots begin after the last contact that is no rebound: a slide, or inferred solid.
    """
    if plan.n < 1:
        return plan
    x, y, vx, vy = plan.states[0]
    initial = motion_at(problem.clearance, problem.constants.grid, x, y, vx, vy)
    rows, contacts = sample_trajectory(problem, initial, plan.commands[: plan.n], 0.0)
    x, y, vx, vy = rows[-1, 1:]
    end = motion_at(problem.clearance, problem.constants.grid, x, y, vx, vy)
    first, rebounds = _rebounds(contacts)
    begin = first * CONTROL_INTERVAL
    if not is_there(problem.constants.goal, end) or rows[-1, 0] - begin < SHORTEST or len(rebounds) >= MOST_PHASES:
        return plan
    time = begin
    for contact in rebounds:
        if contact[0] - time < SHORTEST_PHASE:
            return plan
        time = contact[0]
    if rows[-1, 0] - time < SHORTEST_PHASE:
        return plan
    knots = smooth_knots(problem, knots_of(rows, rebounds, begin))
    commands, n = commands_along(problem, plan, first, knots)
    return roll(problem, initial, commands, n)


@njit
def _rebounds(contacts: np.ndarray) -> tuple[int, np.ndarray]:
    """The first control interval after the last contact that is no rebound or too soon, and the rebounds after it."""
    first, count = 0, 0
    for k in range(len(contacts)):
        if contacts[k, 6] != OBSERVED or contacts[k, 0] < first * CONTROL_INTERVAL + SHORTEST_PHASE:
            first, count = int(math.ceil(contacts[k, 0] / CONTROL_INTERVAL - 1e-6)), k + 1
    return first, contacts[count:]


@njit
def smooth_knots(problem: Problem, knots: Knots) -> Knots:
    """The knots after passes that each lower the cost, until they settle."""
    constants, n, phases = problem.constants, len(knots.accelerations), len(knots.ends)
    margins = margins_of(knots.ends, constants.costs.margin)
    course = Course(problem.clearance, constants, limits_of(constants), margins)
    new = Knots(
        np.zeros_like(knots.states), np.zeros_like(knots.accelerations), np.zeros_like(knots.durations), knots.ends
    )
    gains, models = tracking_gains(n, phases), empty_models()
    cost = forward(course, knots, gains, 0.0, new)
    knots, new = new, knots
    damping = DAMPING
    for _ in range(MOST_PASSES):
        gained = 0.0
        if backward(course, knots, damping, models, gains):
            share = 1.0
            for _ in range(MOST_SHARES):
                gained = cost - forward(course, knots, gains, share, new)
                if gained > 1e-7:
                    break
                share *= NEXT_SHARE
        if gained > 1e-7:
            knots, new, cost = new, knots, cost - gained
            damping = max(damping * LESS_DAMPING, LEAST_DAMPING)
            if gained < SETTLED:
                break
        else:
            damping *= MORE_DAMPING
            if damping > MOST_DAMPING:
                break
    return knots
