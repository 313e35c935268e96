"""Control interval, for which one command holds: its motion and its cost."""

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import ON_THE_WAY, arrival_share, graze_cost, is_there
from collplan_core.time_to_goal_planner.dynamics import (
    NO_CONTACT,
    Motion,
    contact_cost,
    course_of,
    margin_cost,
    step,
)
from collplan_core.time_to_goal_planner.model import INTERVAL_STEPS, STEP, Constants


@njit
def roll_interval(
    clearance: np.ndarray, source: np.ndarray, constants: Constants, begin: Motion, ux: float, uy: float
) -> tuple[Motion, float, float]:
    """A control interval under command u.

    Returns:
        the motion at its end; its cost [s]; time of arrival at the goal since it began [s], or ON_THE_WAY.
    """
    grid, goal, model, costs = constants
    motion, course, cost, touched = begin, course_of(begin, ux, uy), 0.0, False
    for k in range(INTERVAL_STEPS):
        before = motion
        motion, course, contact = step(clearance, source, grid, model, before, course)
        if contact.kind != NO_CONTACT:
            touched = True
            cost += contact_cost(costs, contact)
        if is_there(goal, motion):
            cost += graze_cost(goal, motion)
            return motion, cost, (k + arrival_share(goal, before, motion)) * STEP
    if not touched and motion.clearance_bound < costs.margin:
        cost += margin_cost(clearance, grid, costs, motion)
    return motion, cost, ON_THE_WAY
