"""A whole plan made smooth: iterated passes over its knots, then the commands that follow them."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import is_there
from collplan_core.time_to_goal_planner.boundary_memory.clearance import OBSERVED
from collplan_core.time_to_goal_planner.dynamics import Motion, motion_at
from collplan_core.time_to_goal_planner.full_plan import FullPlan, roll, sample_trajectory
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, Problem
from collplan_core.time_to_goal_planner.smoothing.backward import backward
from collplan_core.time_to_goal_planner.smoothing.commands import commands_along
from collplan_core.time_to_goal_planner.smoothing.forward import forward
from collplan_core.time_to_goal_planner.smoothing.knots import Knots, knots_of, tracking_gains

SHORTEST_PHASE = 0.06
"""Shortest phase [s]: contacts closer together are a slide along a wall."""
MOST_PASSES, MOST_SHARES = 40, 6
"""Backward passes at most, and shares of what each asks for that are tried."""
NEXT_SHARE = 0.4
"""Factor from one share to the next."""
SETTLED, LEAST_GAIN = 3e-4, 1e-7
"""Passes end when one promises or gains less than this; what gains less than the second is not taken [s]."""
DAMPING, LEAST_DAMPING = 1e-4, 1e-6
"""Damping of the first pass, and the least [s^5/m^2]."""
LESS_DAMPING, MORE_DAMPING = 0.3, 10.0
"""Factors on the damping after a pass that lowered the cost and one that did not."""


@njit
def smoothed(problem: Problem, plan: FullPlan) -> FullPlan:
    """The plan with smooth knots followed from where they can be; itself where it does not arrive. It may cost more."""
    x, y, vx, vy = plan.states[0]
    initial = motion_at(problem.clearance, problem.constants.grid, x, y, vx, vy)
    rows, contacts = sample_trajectory(problem, initial, plan.commands[: plan.n], 0.0)
    first, rebounds = _rebounds(contacts)
    begin, end = first * CONTROL_INTERVAL, rows[-1]
    last = rebounds[-1, 0] if len(rebounds) > 0 else begin
    arrives = is_there(problem.constants.goal, Motion(end[1], end[2], end[3], end[4], 0.0, 0))
    if not arrives or end[0] - last < SHORTEST_PHASE:
        return plan
    knots = smooth_knots(problem, knots_of(rows, rebounds, begin, problem.constants.costs.margin))
    commands, n = commands_along(problem, plan, first, knots)
    return roll(problem, initial, commands, n)


@njit
def _rebounds(contacts: np.ndarray) -> tuple[int, np.ndarray]:
    """The first control interval after the last contact that is no rebound or too soon, and the rebounds after it."""
    first, count, before = 0, 0, 0.0
    for k in range(len(contacts)):
        if contacts[k, 8] != OBSERVED or contacts[k, 0] < before + SHORTEST_PHASE:
            first, count = int(math.ceil(contacts[k, 0] / CONTROL_INTERVAL - 1e-6)), k + 1
        before = max(contacts[k, 0], first * CONTROL_INTERVAL)
    return first, contacts[count:]


@njit
def smooth_knots(problem: Problem, knots: Knots) -> Knots:
    """The knots after passes that each lower the cost, until they settle."""
    gains, new, damping = tracking_gains(knots), copied(knots), DAMPING
    cost = forward(problem, knots, gains, 0.0, new)
    knots, new = new, copied(knots)
    for _ in range(MOST_PASSES):
        if -0.5 * backward(problem, knots, damping, gains) < SETTLED:
            break
        gained, share = 0.0, 1.0
        for _ in range(MOST_SHARES):
            gained = cost - forward(problem, knots, gains, share, new)
            if gained > LEAST_GAIN:
                break
            share *= NEXT_SHARE
        if gained > LEAST_GAIN:
            knots, new, cost, damping = new, knots, cost - gained, max(damping * LESS_DAMPING, LEAST_DAMPING)
            if gained < SETTLED:
                break
        else:
            damping *= MORE_DAMPING
    return knots


@njit
def copied(knots: Knots) -> Knots:
    """The knots in arrays of their own, for a pass to write to."""
    return Knots(knots.states.copy(), knots.accelerations.copy(), knots.durations.copy(), knots.ends, knots.margins)
