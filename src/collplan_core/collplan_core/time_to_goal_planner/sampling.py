"""A full plan as a trajectory: where the disc is when, and every contact."""

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import is_there
from collplan_core.time_to_goal_planner.dynamics import NO_CONTACT, SLIDES, Motion, course_of, free_step, step
from collplan_core.time_to_goal_planner.model import INTERVAL_STEPS, STEP, Problem

SHORTEST = 0.01
"""A contact nearer to the beginning or end of a step than this share of it is put there."""


@njit
def sample_trajectory(
    problem: Problem,
    initial: Motion,
    commands: np.ndarray,
    radius: float,
) -> tuple[np.ndarray, np.ndarray]:
    """The rollout of commands (n, 2), one a control interval, to the goal where it gets there.

    Returns:
        rows (k, 5): time since the beginning [s], x, y, vx, vy, also at the moment of every contact;
        contacts (c, 7): time, point touched x, y, velocity after vx, vy, speed into the boundary, kind as in Contact.
    """
    grid, goal, model, _ = problem.constants
    most = len(commands) * INTERVAL_STEPS
    rows, contacts = np.empty((2 * most + 1, 5)), np.empty((most, 7))
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
            contacts[touched, 5], contacts[touched, 6] = contact.normal_speed, contact.kind
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
