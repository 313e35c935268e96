"""Full plans made better by changes at random, each kept only where the cost falls."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import (
    ON_THE_WAY,
    approach_speed,
    end_cost,
    roll_interval,
    stop_cost,
    straight_time,
)
from collplan_core.time_to_goal_planner.dynamics import motion_at
from collplan_core.time_to_goal_planner.full_plan import STOP_TEST_INTERVAL, FullPlan
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, INTERVAL_STEPS, Problem
from collplan_core.time_to_goal_planner.mover_cost import mover_cost
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import path_direction
from collplan_core.velocity_bounds import within

LONGEST_WINDOW = 20
"""Control intervals changed at once."""
MOST_DELETED = 4
"""Control intervals taken out at once."""
BUMPS = (0.12, 0.5)
"""Standard deviations of a bump of velocity [m/s]."""
POSITION_GAIN, VELOCITY_GAIN = 4.0, 0.5
"""Gains with which the old plan is tracked after the window: up to [1/s], and [1]."""
RUN_ON = 4
"""Control intervals for which a plan that is not there goes on straight for the goal."""
DELETE, BUMP, STRAIGHT = 0, 1, 2


class Change(NamedTuple):
    """A change of a window of a plan."""

    kind: int  # DELETE, BUMP or STRAIGHT
    first: int  # first, window: first control interval changed, and how many are
    window: int
    deleted: int  # deleted, where: number of intervals taken out of the window, and the first of them
    where: int
    bump_x: float  # bump_x, bump_y: height of the bump [m/s]
    bump_y: float
    position_gain: float
    velocity_gain: float
    """position_gain, velocity_gain: gains with which the old plan is tracked after the window [1/s], [1]."""


@njit
def refine(problem: Problem, plan: FullPlan, count: int, random: np.random.Generator) -> FullPlan:
    """The plan after `count` changes tried, each kept where it lowers the cost; the arrays are changed in place."""
    commands, states, costs = plan.commands, plan.states, plan.costs
    new = FullPlan(np.empty_like(commands), np.empty_like(states), np.empty_like(costs), 0, 0.0)
    for _ in range(count):
        if plan.n < 1:
            break
        change = _draw_change(random, plan.n)
        n, cost = _roll_changed(problem, plan, change, new)
        if cost < plan.cost - 1e-9:
            first = change.first
            commands[first:n] = new.commands[first:n]
            states[first + 1 : n + 1] = new.states[first + 1 : n + 1]
            costs[first + 1 : n + 1] = new.costs[first + 1 : n + 1]
            plan = FullPlan(commands, states, costs, n, cost)
    return plan


@njit
def _draw_change(random: np.random.Generator, n: int) -> Change:
    """A change of a plan of n control intervals."""
    first = int(random.random() * n)
    window = min(1 + int(random.random() * LONGEST_WINDOW), n - first)
    kind = int(3.0 * random.random())
    deleted = 0
    if kind == DELETE or (kind == STRAIGHT and random.random() < 0.5):
        deleted = 1 + int(random.random() * min(MOST_DELETED, window))
    where = int(random.random() * (window - deleted + 1))
    bump_x = bump_y = 0.0
    if kind == BUMP:
        sigma = BUMPS[int(2.0 * random.random())]
        bump_x, bump_y = sigma * random.standard_normal(), sigma * random.standard_normal()
    position_gain = POSITION_GAIN * random.random() if random.random() < 0.7 else 0.0
    velocity_gain = VELOCITY_GAIN if random.random() < 0.5 else 0.0
    return Change(kind, first, window, deleted, where, bump_x, bump_y, position_gain, velocity_gain)


@njit
def _roll_changed(problem: Problem, plan: FullPlan, change: Change, new: FullPlan) -> tuple[int, float]:
    """Rolls a changed plan from its window on into `new`; its intervals and cost, inf once it cannot be lower."""
    clearance, source, constants = problem.clearance, problem.source, problem.constants
    goal, bounds = constants.goal, constants.bounds
    commands, states = plan.commands, plan.states
    new_commands, new_states, new_costs = new.commands, new.states, new.costs
    kind, first, window, deleted, where, bump_x, bump_y, position_gain, velocity_gain = change
    x, y, vx, vy = states[first, 0], states[first, 1], states[first, 2], states[first, 3]
    motion = motion_at(clearance, constants.grid, x, y, vx, vy, first * INTERVAL_STEPS)
    total = plan.costs[first]
    n, best = plan.n, plan.cost
    stop, last = first + window - deleted, min(n - deleted + RUN_ON, len(commands))
    end_x, end_y = states[first + window, 0], states[first + window, 1]
    for k in range(first, last):
        old = k + deleted if k >= first + where else k
        if k < stop and kind == STRAIGHT:
            dx, dy = end_x - motion.x, end_y - motion.y
            length = math.sqrt(dx * dx + dy * dy)
            share = bounds.fastest / length if length > 1e-6 else 0.0
            ux, uy = share * dx, share * dy
        elif k < stop:
            ux, uy = commands[old, 0], commands[old, 1]
            if kind == BUMP:
                weight = math.sin(math.pi * (k - first + 0.5) / window)
                ux, uy = ux + weight * bump_x, uy + weight * bump_y
        elif old < n:
            off_x, off_y = states[old, 0] - motion.x, states[old, 1] - motion.y
            ux = commands[old, 0] + position_gain * off_x + velocity_gain * (states[old, 2] - motion.vx)
            uy = commands[old, 1] + position_gain * off_y + velocity_gain * (states[old, 3] - motion.vy)
        else:
            ux, uy, _ = path_direction(problem.paths, motion.x, motion.y)
            speed = approach_speed(constants, motion)
            ux, uy = speed * ux, speed * uy
        ux, uy = within(bounds, ux, uy)
        motion, cost, arrival = roll_interval(clearance, source, constants, motion, ux, uy)
        total += cost
        if len(problem.movers) + len(problem.trails) > 0:
            total += mover_cost(problem.movers, problem.trails, (k + 1) * CONTROL_INTERVAL, CONTROL_INTERVAL, motion)
        new_commands[k, 0], new_commands[k, 1] = ux, uy
        new_states[k + 1, 0], new_states[k + 1, 1] = motion.x, motion.y
        new_states[k + 1, 2], new_states[k + 1, 3] = motion.vx, motion.vy
        if problem.stop_test and k + 1 == STOP_TEST_INTERVAL:
            total += stop_cost(problem, motion)
        new_costs[k + 1] = total
        if arrival != ON_THE_WAY:
            return k + 1, k * CONTROL_INTERVAL + arrival + total
        if total + (k + 1) * CONTROL_INTERVAL + straight_time(goal, bounds, motion) >= best:
            return k + 1, np.inf
    return last, last * CONTROL_INTERVAL + total + end_cost(problem, motion)
