"""Commands, one a control interval, that follow knots under the planner's own dynamics."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import ON_THE_WAY, roll_interval
from collplan_core.time_to_goal_planner.dynamics import motion_at
from collplan_core.time_to_goal_planner.full_plan import FullPlan
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, INTERVAL_STEPS, Problem
from collplan_core.time_to_goal_planner.smoothing.knots import Knots
from collplan_core.velocity_bounds import within
from collplan_core.velocity_law import command_lead

PLACE_GAIN = 5.0
"""Gain with which a place beside the knots is led back [1/s]."""
OTHER_SIDE = 0.5
"""So far off the knots' velocity the robot is before a contact that they are past, or past one that they are before
[m/s]."""
RUN_ON = 6
"""Control intervals for which the knots are followed beyond their end, where the robot comes there late."""


@njit
def commands_along(problem: Problem, plan: FullPlan, first: int, knots: Knots) -> tuple[np.ndarray, int]:
    """Commands (m, 2) of a plan up to number `first`, then those that follow the knots from there; how many."""
    clearance, source, constants = problem.clearance, problem.source, problem.constants
    wheels, bounds = constants.model.wheels, constants.bounds
    commands, now, then = plan.commands.copy(), np.zeros(4), np.zeros(4)
    x, y, vx, vy = plan.states[first]
    motion = motion_at(clearance, constants.grid, x, y, vx, vy, first * INTERVAL_STEPS)
    phase, knot, begin = 0, 0, 0.0
    for k in range(first, len(commands)):
        time = (k - first) * CONTROL_INTERVAL
        duration = knots.durations[phase] * (knots.ends[phase] - knot)
        while phase < len(knots.ends) - 1 and time >= begin + duration - 1e-9:
            begin, knot, phase = begin + duration, knots.ends[phase], phase + 1
            duration = knots.durations[phase] * (knots.ends[phase] - knot)
        if time > begin + duration + RUN_ON * CONTROL_INTERVAL:
            return commands, k
        _write_state(knots, phase, knot, time - begin, now)
        _write_state(knots, phase, knot, time - begin + CONTROL_INTERVAL, then)
        dx, dy = then[2] - now[2], then[3] - now[3]
        if math.hypot(now[2] - motion.vx, now[3] - motion.vy) < OTHER_SIDE:
            dx, dy = then[2] - motion.vx, then[3] - motion.vy
            off_x = then[0] - motion.x - 0.5 * CONTROL_INTERVAL * (motion.vx + then[2])
            off_y = then[1] - motion.y - 0.5 * CONTROL_INTERVAL * (motion.vy + then[3])
            dx, dy = dx + PLACE_GAIN * off_x, dy + PLACE_GAIN * off_y
        change = math.hypot(dx, dy)
        gain = command_lead(wheels, change, CONTROL_INTERVAL) / change if change > 1e-9 else 0.0
        ux, uy = within(bounds, motion.vx + gain * dx, motion.vy + gain * dy)
        commands[k, 0], commands[k, 1] = ux, uy
        motion, _, arrival = roll_interval(clearance, source, constants, motion, ux, uy)
        if arrival != ON_THE_WAY:
            return commands, k + 1
    return commands, len(commands)


@njit
def _write_state(knots: Knots, phase: int, first: int, time: float, state: np.ndarray) -> None:
    """Writes the state a time [s] after a phase began at knot `first`; beyond its end as if nothing were there."""
    tau = knots.durations[phase]
    k = min(first + int(time / tau), knots.ends[phase] - 1)
    rest, (x, y, vx, vy), (ax, ay) = time - (k - first) * tau, knots.states[k], knots.accelerations[k]
    state[0], state[1] = x + rest * (vx + 0.5 * rest * ax), y + rest * (vy + 0.5 * rest * ay)
    state[2], state[3] = vx + rest * ax, vy + rest * ay
