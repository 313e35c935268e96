"""What refinement starts from: the best coarse plans, and the plan in force carried on."""

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.control_interval import ON_THE_WAY, roll_knot
from collplan_core.time_to_goal_planner.full_plan import clip, near_at
from collplan_core.time_to_goal_planner.model import KNOT, KNOT_STEPS, Law, Price, Scene


def best_coarse(j: np.ndarray, count: int) -> list[tuple[int, int, int]]:
    """Places in J (first target, switch, second target) of the best plans with different first targets."""
    n = len(j)
    flat = j.reshape(n, -1)
    within = flat.argmin(axis=1)
    order = np.argsort(flat[np.arange(n), within], kind="stable")[:count]
    places = [np.unravel_index(int(within[a]), j.shape[1:]) for a in order]
    return [(int(a), int(b), int(c)) for a, (b, c) in zip(order, places, strict=True)]


def coarse_commands(commands: np.ndarray, first: np.ndarray, second: np.ndarray, switch: int, n_steps: int) -> int:
    """Writes a coarse plan into commands (m, 2); knots there are then."""
    n = min(n_steps // KNOT_STEPS, len(commands))
    commands[: min(switch // KNOT_STEPS, n)] = first
    commands[switch // KNOT_STEPS : n] = second
    return n


def padded(commands: np.ndarray, most: int) -> np.ndarray:
    """Commands (n, 2) in an array (most, 2)."""
    result = np.zeros((most, 2))
    result[: len(commands)] = commands[:most]
    return result


def shifted(commands: np.ndarray, passed: float) -> np.ndarray:
    """What is left of commands (n, 2), one a knot, after `passed` [s]: the one in force in the middle of each knot."""
    middles = passed + KNOT * (np.arange(len(commands)) + 0.5)
    at = np.floor(middles / KNOT).astype(int)
    return commands[at[(at >= 0) & (at < len(commands))]]


@njit
def tracked(scene: Scene, law: Law, price: Price, begin: np.ndarray, commands: np.ndarray, positions: np.ndarray,
            gain: float) -> np.ndarray:  # fmt: skip
    """Commands (n, 2) that from begin (x, y, vx, vy) lead back to the positions (n, 2) where they should have led."""
    clearance, source, grid, goal = scene.clearance, scene.source, scene.grid, scene.goal
    result = commands.copy()
    x, y, vx, vy = begin
    near = near_at(scene, x, y)
    for k in range(len(commands)):
        ux, uy = clip(
            commands[k, 0] + gain * (positions[k, 0] - x), commands[k, 1] + gain * (positions[k, 1] - y), law.max_speed
        )
        result[k, 0], result[k, 1] = ux, uy
        x, y, vx, vy, near, _, arrival = roll_knot(
            clearance, source, grid, goal, law, price, x, y, vx, vy, near, ux, uy
        )
        if arrival != ON_THE_WAY:
            break
    return result
