"""Whole plans made better by changes at random, each kept only where J falls."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.coarse_search import toward
from collplan_core.time_to_goal_planner.control_interval import ON_THE_WAY, roll_knot
from collplan_core.time_to_goal_planner.full_plan import STOP_TEST_KNOT, clip, end_cost, near_at, stop_cost
from collplan_core.time_to_goal_planner.model import KNOT, Law, Price, Scene

LONGEST_WINDOW = 20
"""Knots changed at once."""
MOST_DELETED = 4
"""Knots taken out at once."""
BUMPS = (0.12, 0.5)
"""Standard deviations of a bump of velocity [m/s]."""
TRACKING_GAIN, VELOCITY_GAIN = 4.0, 0.5
"""Gains with which the old plan is tracked after the window: up to [1/s], and [1]."""
RUN_ON = 4
"""Knots for which a plan that is not there goes on straight for the goal."""
DELETE, BUMP, STRAIGHT = 0, 1, 2


@njit
def refine(scene: Scene, law: Law, price: Price, stop_test: bool, random: np.random.Generator, count: int,
           commands: np.ndarray, states: np.ndarray, costs: np.ndarray, n: int, j: float,
           ) -> tuple[int, float, int]:  # fmt: skip
    """Tries `count` changes on a plan of n knots and J = j, in place.

    Args:
        commands: (m, 2) [m/s], states: (m + 1, 4), costs: (m + 1,) as `whole.roll` fills them.

    Returns:
        knots, J, changes kept.
    """
    most, kept = len(commands), 0
    new_commands, new_states, new_costs = np.empty_like(commands), np.empty_like(states), np.empty_like(costs)
    for _ in range(count):
        if n < 1:
            break
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
        gain = TRACKING_GAIN * random.random() if random.random() < 0.7 else 0.0
        velocity_gain = VELOCITY_GAIN if random.random() < 0.5 else 0.0
        m, total = _changed(
            scene, law, price, stop_test, commands, states, costs, n, j, first, window, kind, deleted, where, bump_x,
            bump_y, gain, velocity_gain, most, new_commands, new_states, new_costs,
        )  # fmt: skip
        if total < j - 1e-9:
            commands[first:m], states[first : m + 1], costs[first : m + 1] = (
                new_commands[first:m], new_states[first : m + 1], new_costs[first : m + 1],
            )  # fmt: skip
            n, j, kept = m, total, kept + 1
    return n, j, kept


@njit
def _changed(scene: Scene, law: Law, price: Price, stop_test: bool, commands: np.ndarray, states: np.ndarray,
             costs: np.ndarray, n: int, best: float, first: int, window: int, kind: int, deleted: int, where: int,
             bump_x: float, bump_y: float, gain: float, velocity_gain: float, most: int, new_commands: np.ndarray,
             new_states: np.ndarray, new_costs: np.ndarray) -> tuple[int, float]:  # fmt: skip
    """Rolls one change from its window on: knots and J, inf as soon as it cannot be better than `best`."""
    clearance, source, grid, goal = scene.clearance, scene.source, scene.grid, scene.goal
    x, y, vx, vy = states[first]
    near = near_at(scene, x, y)
    new_states[first] = states[first]
    new_costs[first] = costs[first]
    total = costs[first]
    stop = first + window - deleted
    end_x, end_y = states[first + window, 0], states[first + window, 1]
    k = first
    while k < min(n - deleted + RUN_ON, most):
        old = k + deleted if k >= first + where else k
        if k < stop:
            if kind == STRAIGHT:
                dx, dy = end_x - x, end_y - y
                length = math.sqrt(dx * dx + dy * dy)
                share = law.max_speed / length if length > 1e-6 else 0.0
                ux, uy = share * dx, share * dy
            else:
                ux, uy = commands[old, 0], commands[old, 1]
                if kind == BUMP:
                    weight = math.sin(math.pi * (k - first + 0.5) / window)
                    ux, uy = ux + weight * bump_x, uy + weight * bump_y
        elif old < n:
            ux = commands[old, 0] + gain * (states[old, 0] - x) + velocity_gain * (states[old, 2] - vx)
            uy = commands[old, 1] + gain * (states[old, 1] - y) + velocity_gain * (states[old, 3] - vy)
        else:
            ux, uy, _ = toward(scene, x, y)
            ux, uy = law.max_speed * ux, law.max_speed * uy
        ux, uy = clip(ux, uy, law.max_speed)
        x, y, vx, vy, near, cost, arrival = roll_knot(
            clearance, source, grid, goal, law, price, x, y, vx, vy, near, ux, uy
        )
        total += cost
        new_commands[k, 0], new_commands[k, 1] = ux, uy
        k += 1
        new_states[k, 0], new_states[k, 1], new_states[k, 2], new_states[k, 3] = x, y, vx, vy
        if stop_test and k == STOP_TEST_KNOT:
            total += stop_cost(scene, law, new_states[k])
        new_costs[k] = total
        if arrival != ON_THE_WAY:
            return k, (k - 1) * KNOT + arrival + total
        left = math.sqrt((x - scene.goal.x) ** 2 + (y - scene.goal.y) ** 2) - scene.goal.tolerance
        if total + k * KNOT + left / law.max_speed >= best:
            return k, np.inf
    return k, k * KNOT + total + end_cost(scene, law, new_states[k])
