"""The peer of the coarse rollouts: the same law in numpy, one array operation for all rollouts of a step.

It says where each rollout ends and what its contacts cost. The compiled one also says how long it takes from there to
the goal, and begins rollouts that share their first velocity only once.
"""

from dataclasses import dataclass

import numpy as np

from collplan_core.time_to_goal_planner.boundary_memory.clearance import FAR, INFERRED, NOTHING, OBSERVED
from collplan_core.time_to_goal_planner.coarse_search import SWITCH_STEPS
from collplan_core.time_to_goal_planner.dynamics import NO_CONTACT, SLIDES, Motion
from collplan_core.time_to_goal_planner.model import (
    EXCLUDED,
    EXCLUDED_BY_SPEED,
    IMPACT_SPEED,
    STEP,
    ContactCosts,
    Problem,
    RobotModel,
)
from collplan_core.velocity_law import VelocityLaw


@dataclass(eq=False)
class Robots:
    """Robots side by side: positions, velocities and commands (2, k), what the clearance is at least (k,)."""

    position: np.ndarray
    velocity: np.ndarray
    command: np.ndarray
    near: np.ndarray

    def of(self, which: np.ndarray) -> "Robots":
        """Some of them."""
        return Robots(self.position[:, which], self.velocity[:, which], self.command[:, which], self.near[which])

    def put(self, which: np.ndarray, others: "Robots") -> None:
        """Others in the places of some of them."""
        self.position[:, which], self.velocity[:, which] = others.position, others.velocity
        self.near[which] = others.near


def vectorised_plans(
    problem: Problem, initial: Motion, velocities: np.ndarray, n_steps: int
) -> tuple[np.ndarray, np.ndarray]:
    """Every pair of velocities (n, 2) with every time of the switch, each rolled from the beginning.

    Args:
        n_steps: the horizon.

    Returns:
        ends (n, m, n, 4) and cost of contacts (n, m, n) [s] by first velocity, switch and second velocity.
    """
    n, m = len(velocities), len(SWITCH_STEPS)
    first, switch, second = (each.ravel() for each in np.meshgrid(range(n), SWITCH_STEPS, range(n), indexing="ij"))
    ends, cost = np.empty((4, len(first))), np.zeros(len(first))
    rolling = np.arange(len(first))
    goal, start = problem.constants.goal, np.repeat(np.array(initial)[:, None], len(first), axis=1)
    robots = Robots(start[:2], start[2:4], velocities[first].T.copy(), start[4])
    for k in range(n_steps):
        if k in SWITCH_STEPS:
            turns = switch[rolling] == k
            robots.command[:, turns] = velocities[second[rolling[turns]]].T
        touching, paid = _step(problem, robots)
        cost[rolling[touching]] += paid
        x, y = robots.position
        arrived = (x - goal.x) ** 2 + (y - goal.y) ** 2 <= goal.tolerance**2
        if arrived.any():
            ends[:, rolling[arrived]] = np.vstack([robots.position, robots.velocity])[:, arrived]
            rolling, robots = rolling[~arrived], robots.of(~arrived)
    ends[:, rolling] = np.vstack([robots.position, robots.velocity])
    return ends.T.reshape(n, m, n, 4), cost.reshape(n, m, n)


def _step(problem: Problem, robots: Robots) -> tuple[np.ndarray, np.ndarray]:
    """STEP, in place: which ones touch something, and what that costs [s]."""
    before = Robots(robots.position, robots.velocity, robots.command, robots.near)
    robots.velocity = _driven(
        before.velocity, before.command, np.full(len(before.near), STEP), problem.constants.model.wheels
    )
    moved = 0.5 * (before.velocity + robots.velocity) * STEP
    robots.position = before.position + moved
    robots.near = before.near - np.abs(moved[0]) - np.abs(moved[1])
    looked = np.flatnonzero(robots.near <= 0.0)
    robots.near[looked] = after = _clearance(problem, robots.position[:, looked])
    touching = looked[after < 0.0]
    if len(touching) == 0:
        return touching, np.zeros(0)
    off, cost = _step_with_contact(problem, before.of(touching), robots.of(touching))
    robots.put(touching, off)
    return touching, cost


def _driven(velocity: np.ndarray, command: np.ndarray, duration: np.ndarray, law: VelocityLaw) -> np.ndarray:
    """(2, k) velocity after durations (k,) [s]."""
    change = command - velocity
    gap = np.sqrt(change[0] * change[0] + change[1] * change[1])
    linear = law.max_acceleration * law.lag
    share = law.max_acceleration * duration / np.maximum(gap, linear)
    # the exponential costs more than all the rest: only where it is wanted
    slows = np.flatnonzero(gap - linear < law.max_acceleration * duration)
    saturated = np.maximum(gap[slows] - linear, 0.0) / law.max_acceleration
    left = np.exp((saturated - duration[slows]) / law.lag)
    share[slows] = 1.0 - linear * left / np.maximum(gap[slows], linear)
    return velocity + share * change


def _cell(problem: Problem, position: np.ndarray) -> tuple[np.ndarray, ...]:
    """Where in the clearance field positions (2, k) are: inside or not, the cell's clearances, shares along x and y."""
    (nx, ny), grid = problem.clearance.shape, problem.constants.grid
    scale = 1.0 / grid.spacing
    fx, fy = (position[0] - grid.x) * scale, (position[1] - grid.y) * scale
    inside = (fx >= 0.0) & (fx < nx - 1) & (fy >= 0.0) & (fy < ny - 1)
    i, j = np.where(inside, fx, 0.0).astype(int), np.where(inside, fy, 0.0).astype(int)
    corner = i * ny + j
    flat = problem.clearance.ravel()
    return inside, flat[corner], flat[corner + 1], flat[corner + ny], flat[corner + ny + 1], fx - i, fy - j


def _clearance(problem: Problem, position: np.ndarray) -> np.ndarray:
    """(k,) at positions (2, k), linear between the nodes [m]."""
    inside, c00, c01, c10, c11, a, b = _cell(problem, position)
    return np.where(inside, (1.0 - a) * ((1.0 - b) * c00 + b * c01) + a * ((1.0 - b) * c10 + b * c11), FAR)


def _normal(problem: Problem, position: np.ndarray) -> np.ndarray:
    """(2, k) unit directions out of the boundary at positions (2, k)."""
    half = 0.5 * problem.constants.grid.spacing
    along = np.stack(
        [
            _clearance(problem, position + step) - _clearance(problem, position - step)
            for step in half * np.eye(2)[:, :, None]
        ]
    )
    length = np.hypot(*along)
    return np.where(length > 1e-12, along / np.maximum(length, 1e-300), 0.0)


def _source(problem: Problem, position: np.ndarray) -> np.ndarray:
    """(k,) what the boundary nearest to positions (2, k) is."""
    (nx, ny), grid = problem.source.shape, problem.constants.grid
    i = np.floor((position[0] - grid.x) / grid.spacing + 0.5).astype(int)
    j = np.floor((position[1] - grid.y) / grid.spacing + 0.5).astype(int)
    inside = (i >= 0) & (i < nx) & (j >= 0) & (j < ny)
    return np.where(inside, problem.source[np.clip(i, 0, nx - 1), np.clip(j, 0, ny - 1)], NOTHING)


def _step_with_contact(problem: Problem, before: Robots, after: Robots) -> tuple[Robots, np.ndarray]:
    """A step that ends inside a boundary: up to the contact, off it, and on; what that costs [s]."""
    model, costs = problem.constants.model, problem.constants.costs
    share = _share(problem, before, after)
    contact = before.position + share * (after.position - before.position)
    normal = _normal(problem, contact)
    velocity = before.velocity + share * (after.velocity - before.velocity)
    into = -(velocity * normal).sum(axis=0)
    kind = np.where(_source(problem, contact) != INFERRED, OBSERVED, INFERRED)
    kind = np.where(into > IMPACT_SPEED, kind, np.where(into > 0.0, SLIDES, NO_CONTACT))
    velocity = _off(model, velocity, normal, into, kind)
    rest = (1.0 - share) * STEP
    end = _driven(velocity, before.command, rest, model.wheels)
    slides = (kind == SLIDES) | (kind == NO_CONTACT)
    end = end + np.where(slides, np.maximum(-(end * normal).sum(axis=0), 0.0), 0.0) * normal
    position = contact + 0.5 * (velocity + end) * rest
    near = _clearance(problem, position)
    position = position - np.minimum(near, 0.0) * _normal(problem, position)
    return Robots(position, end, before.command, np.maximum(near, 0.0)), _cost(costs, kind, into)


def _share(problem: Problem, before: Robots, after: Robots) -> np.ndarray:
    """(k,) of the step up to the contact: one step of false position."""
    near = _clearance(problem, before.position)
    outside = near > 1e-4
    near = np.where(outside, near, 1.0)
    share = near / (near - after.near)
    middle = _clearance(problem, before.position + share * (after.position - before.position))
    beyond = share + (1.0 - share) * middle / np.where(middle > 0.0, middle - after.near, 1.0)
    short = share * near / np.where(middle > 0.0, 1.0, near - middle)
    return np.where(outside, np.where(middle > 0.0, beyond, short), 0.0)


def _off(model: RobotModel, velocity: np.ndarray, normal: np.ndarray, into: np.ndarray, kind: np.ndarray) -> np.ndarray:
    """(2, k) velocity after the contact, of a disc without spin."""
    ring = model.ring
    along = velocity + into * normal
    restitution = np.where(kind == OBSERVED, ring.restitution, 0.0)
    slip = np.hypot(*along)
    grip = np.minimum(ring.friction * (1.0 + restitution) * into, slip * ring.inertia_factor)
    change = (1.0 + restitution) * into * normal - grip / np.maximum(slip, 1e-300) * along
    reflected = velocity + ring.body_share * change
    hits = (kind == OBSERVED) | (kind == INFERRED)
    return np.where(hits, reflected, np.where(kind == SLIDES, along, velocity))


def _cost(costs: ContactCosts, kind: np.ndarray, into: np.ndarray) -> np.ndarray:
    """(k,) what the contacts cost [s]."""
    beyond = np.where(into > costs.limit, EXCLUDED + EXCLUDED_BY_SPEED * (into - costs.limit), 0.0)
    observed = costs.fixed + costs.by_speed * into + beyond
    inferred = costs.inferred_fixed + costs.inferred_by_speed * into + beyond
    return np.where(kind == OBSERVED, observed, np.where(kind == INFERRED, inferred, 0.0))
