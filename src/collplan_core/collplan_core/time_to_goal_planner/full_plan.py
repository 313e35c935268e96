"""A full plan, from now to the goal, and its trajectory: where the disc is when, and every contact."""

from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import (
    ON_THE_WAY,
    STOP_TEST_STEPS,
    end_cost,
    is_there,
    roll_interval,
    stop_cost,
)
from collplan_core.time_to_goal_planner.dynamics import NO_CONTACT, SLIDES, Motion, course_of, free_step, step
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, INTERVAL_STEPS, STEP, Problem
from collplan_core.time_to_goal_planner.mover_cost import mover_cost

STOP_TEST_INTERVAL = STOP_TEST_STEPS // INTERVAL_STEPS


class FullPlan(NamedTuple):
    """Commands and what they lead to; there is room for more than the n control intervals in use."""

    commands: np.ndarray  # (m, 2) [m/s]
    states: np.ndarray  # (m + 1, 4) x, y, vx, vy before each interval and after the last
    costs: np.ndarray  # (m + 1,) cost up to each of the states, its time left out [s]
    n: int  # intervals in use
    cost: float  # cost of the plan, its time included [s]


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
        if len(problem.movers) + len(problem.trails) > 0:
            cost += mover_cost(problem.movers, problem.trails, (k + 1) * CONTROL_INTERVAL, CONTROL_INTERVAL, motion)
        costs[k + 1] = costs[k] + cost
        if problem.stop_test and k + 1 == STOP_TEST_INTERVAL:
            costs[k + 1] += stop_cost(problem, motion)
        if arrival != ON_THE_WAY:
            return FullPlan(commands, states, costs, k + 1, k * CONTROL_INTERVAL + arrival + costs[k + 1])
    return FullPlan(commands, states, costs, n, n * CONTROL_INTERVAL + costs[n] + end_cost(problem, motion))


def braking(problem: Problem, initial: Motion) -> FullPlan:
    """The plan that commands rest, whatever it is charged for."""
    fastest, wheels = problem.constants.bounds.fastest, problem.constants.model.wheels
    n = round(2.0 * fastest / wheels.max_acceleration / CONTROL_INTERVAL) + 1
    return roll(problem._replace(stop_test=False), initial, np.zeros((n, 2)), n)


SHORTEST = 0.01
"""A contact nearer to the beginning or end of a step than this share of it is put there."""


@njit
def sample_trajectory(
    problem: Problem,
    initial: Motion,
    commands: np.ndarray,
    radius: float,
) -> tuple[np.ndarray, np.ndarray]:
    """The rollout of commands (n, 2), one a control interval, to the goal where it gets there: its rows and contacts.

    Rows (k, 5): time since the beginning [s], x, y, vx, vy, also at the moment of every contact. Contacts (c, 9): time,
    point touched x, y, velocity after vx, vy, unit normal out of the boundary x, y, speed into it, kind as in Contact.
    """
    grid, goal, model, _, _ = problem.constants
    most = len(commands) * INTERVAL_STEPS
    rows, contacts = np.empty((2 * most + 1, 5)), np.empty((most, 9))
    motion, count, touched, course = initial, 1, 0, course_of(initial, 0.0, 0.0)
    _put(rows, 0, 0.0, motion.x, motion.y, motion)
    for k in range(most):
        if k % INTERVAL_STEPS == 0:
            ux, uy = commands[k // INTERVAL_STEPS]
            course = course_of(motion, ux, uy)
        before, time = motion, k * STEP
        free = free_step(model.wheels, before, course)[0]
        motion, course, contact = step(problem.clearance, problem.source, grid, model, before, course)
        if contact.kind != NO_CONTACT:
            share = contact.share
            cx, cy = before.x + share * (free.x - before.x), before.y + share * (free.y - before.y)
            if contact.kind != SLIDES and SHORTEST < share < 1.0 - SHORTEST:
                _put(rows, count, time + share * STEP, cx, cy, motion)
                count += 1
            _put(contacts, touched, time + share * STEP, cx - radius * contact.nx, cy - radius * contact.ny, motion)
            contacts[touched, 5], contacts[touched, 6] = contact.nx, contact.ny
            contacts[touched, 7], contacts[touched, 8] = contact.normal_speed, contact.kind
            touched += 1
        _put(rows, count, time + STEP, motion.x, motion.y, motion)
        count += 1
        if is_there(goal, motion):
            break
    return rows[:count], contacts[:touched]


@njit
def _put(rows: np.ndarray, k: int, time: float, x: float, y: float, motion: Motion) -> None:
    """Writes a time, a place and a motion's velocity into row k."""
    rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3], rows[k, 4] = time, x, y, motion.vx, motion.vy
