"""The sampling planner: reading `plan_cycle` top to bottom is reading the paper's II and III-A."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from collplan_core.deadline import Deadline, never
from collplan_core.local_map.free_space import inside
from collplan_core.local_map.record import LocalMap
from collplan_core.movers.record import Movers
from collplan_core.paper_planner.costs.model import CostModel, cost_model
from collplan_core.paper_planner.costs.position import position_costs, straight_on
from collplan_core.paper_planner.costs.risk import collision_risks, crossings, gap_risks
from collplan_core.paper_planner.costs.total import LEAST_WHERE_SPEED_IS_FREE, TERMS, TOTAL, least_first, weighted_terms
from collplan_core.paper_planner.costs.velocity import rebound_rewards, unit_vector, velocity_costs
from collplan_core.paper_planner.foreseen_contacts import foreseen_contacts
from collplan_core.paper_planner.sampling_space import SamplingSpace, sampling_space
from collplan_core.paper_planner.trajectory import make_trajectory
from collplan_core.parameters import Settings
from collplan_core.plan import Candidates, NoPlan, Plan
from collplan_core.state import State
from collplan_core.velocity_bounds import velocity_bounds

FORESEEN = np.arange(0.1, 1.05, 0.1)
"""Times at which the robot and the movers are compared [s]."""
PACE = 0.5
"""Share of v_max at which the robot is expected to drive to a candidate."""


def meets_a_mover(points: np.ndarray, movers: Movers, state: State, settings: Settings) -> np.ndarray:
    """(n,) whether the straight way to each of the points (n, 2) [m] leads into a mover within a second.

    Only what the robot comes nearer to than it is counts: a robot beside a mover may leave it.
    """
    if len(movers) == 0:
        return np.zeros(len(points), dtype=bool)
    way = points - state.position
    length = np.maximum(np.hypot(*way.T), 1e-9)
    driven = np.minimum(PACE * settings.robot.max_speed * FORESEEN[:, None] / length, 1.0)
    robot = state.position + driven[:, :, None] * way
    rows = movers.rows_at(state.stamp)
    discs = rows[:, :2] + FORESEEN[:, None, None] * rows[:, 2:4]
    apart = np.hypot(*np.moveaxis(robot[:, :, None] - discs[:, None], -1, 0))
    now = np.hypot(*(state.position - rows[:, :2]).T)
    wanted = np.minimum(settings.robot.radius + rows[:, 4] + settings.movers.clearance, now - 1e-6)
    return np.any(apart < wanted, axis=(0, 2))


NO_AIM = np.full(2, np.nan)
AROUND = np.array([(np.cos(angle), np.sin(angle)) for angle in np.arange(8) * np.pi / 4])
SHARE_OF_TOLERANCE = 0.8
"""Directions, and distance from a goal that a mover stands beside, in which another end is looked for."""
SIGHT_SHARE = 0.92
"""Share of the local map's half side that must be free in a direction for it to count as sight."""
BLOCKED = 1e6
"""Cost of a candidate that a mover is in the way to: only where all are blocked one of them is chosen."""


@dataclass(frozen=True, eq=False)
class PaperMemory:
    """Memory that one planning cycle leaves to the next, world frame."""

    previous: np.ndarray  # (2,) p_pre, where the previous plan was made [m]
    aim: np.ndarray  # (2,) p_s of the previous plan [m]; NaN where that aimed at the goal, or before the first plan
    travelled: float  # length of the way from p_ini to p_pre [m]


class _Choice(NamedTuple):
    """q_s = (p_s, v_s), world frame, and what it was chosen from."""

    aim: np.ndarray
    aim_velocity: np.ndarray
    terms: dict[str, float]
    candidates: Candidates
    n_before_pruning: int


def plan_cycle(
    memory: PaperMemory | None,
    local_map: LocalMap,
    state: State,
    goal: np.ndarray,
    settings: Settings,
    deadline: Deadline = never,
) -> tuple[Plan, PaperMemory]:
    """One cycle of the paper's planner: from a local map to a timed reference. Paper: II and III-A.

    `memory` is that of the previous cycle, None at the start and after a new goal. The plan begins at `state`: at the
    scan's stamp, or later. The goal (2,) is p_goal [m]. The deadline is not needed: a cycle takes less than a
    millisecond.

    Raises:
        NoPlan: the goal is not in F and F has no frontier.
    """
    # own copies: a read-only array is another type to the compiler, and would be compiled for once more
    state = State(state.stamp, np.array(state.position), np.array(state.velocity), state.yaw)
    goal = np.array(goal, dtype=float)
    memory = memory or PaperMemory(state.position, NO_AIM, 0.0)
    travelled = memory.travelled + float(np.hypot(*(state.position - memory.previous)))
    end = _end_at(goal, local_map, settings.planner.goal_tolerance)
    if end is not None and len(local_map.returns.movers) > 0:
        end = _clear_of_movers(end, local_map, state, settings)
    choice = _best(memory, travelled, local_map, state, goal, settings) if end is None else _goal_itself(end)
    times, positions, velocities = make_trajectory(state, choice.aim, choice.aim_velocity, settings)
    times = state.stamp + times
    plan = Plan(
        stamp=state.stamp,
        times=times,
        positions=positions,
        velocities=velocities,
        contacts=foreseen_contacts(local_map, times, positions, velocities, settings),
        aim=choice.aim,
        aim_velocity=choice.aim_velocity,
        terms=choice.terms,
        candidates=choice.candidates,
        n_before_pruning=choice.n_before_pruning,
    )
    return plan, PaperMemory(state.position, choice.aim if end is None else NO_AIM, travelled)


def _end_at(goal: np.ndarray, local_map: LocalMap, tolerance: float) -> np.ndarray | None:
    """The goal (2,) [m], or if a surface is too near to it the nearest free place within the tolerance; else None."""
    if inside(local_map.border, *(goal - local_map.position)):
        return goal
    beside = local_map.border_points[local_map.surface >= 0]
    away = np.hypot(*(beside - goal).T)
    return beside[away.argmin()] if away.min(initial=np.inf) < tolerance else None


def _clear_of_movers(end: np.ndarray, local_map: LocalMap, state: State, settings: Settings) -> np.ndarray | None:
    """The end (2,) [m], or if a mover is in the way to it another free place within the tolerance; else None."""
    ends = end + np.vstack([np.zeros(2), SHARE_OF_TOLERANCE * settings.planner.goal_tolerance * AROUND])
    free = local_map.contains(ends) & ~meets_a_mover(ends, local_map.returns.movers, state, settings)
    return ends[free.argmax()] if free.any() else None


def _goal_itself(goal: np.ndarray) -> _Choice:
    """Returns the choice of a goal in F itself, reached at rest."""
    at_rest = np.zeros(2)
    return _Choice(goal, at_rest, dict.fromkeys(TERMS, 0.0), Candidates(goal[None], at_rest[None], np.zeros(1)), 1)


def _best(
    memory: PaperMemory, travelled: float, local_map: LocalMap, state: State, goal: np.ndarray, settings: Settings
) -> _Choice:
    """q_s = argmin over C of w_p J_pos + w_r J_risk + w_v J_vel. Paper: eq. (1)."""
    center, model = local_map.position, cost_model(settings)
    bounds = velocity_bounds(settings.robot, state.yaw)
    space = sampling_space(local_map, goal - center, bounds, settings.planner)
    if len(space.positions) == 0:
        raise NoPlan("no frontier in the local map and the goal is not in free space")
    terms = _evaluated(space, memory, travelled, local_map, state, goal, model, settings)
    blocked = meets_a_mover(space.points + center, local_map.returns.movers, state, settings)
    costs = terms[:, TOTAL] + BLOCKED * blocked
    best = _least(costs, space, state.position - center, model, settings)
    return _Choice(
        space.points[best] + center,
        space.velocities[best],
        dict(zip(TERMS, terms[best].tolist(), strict=True)),
        Candidates(space.points + center, space.velocities, costs, terms=dict(zip(TERMS, terms.T, strict=True))),
        space.n_before_pruning,
    )


def _evaluated(
    space: SamplingSpace,
    memory: PaperMemory,
    travelled: float,
    local_map: LocalMap,
    state: State,
    goal: np.ndarray,
    model: CostModel,
    settings: Settings,
) -> np.ndarray:
    """(c, len(TERMS)) the terms of every candidate. Paper: II-B."""
    p, bounds = settings.planner, velocity_bounds(settings.robot, state.yaw)
    center, border = local_map.position, local_map.border
    current, target = state.position - center, goal - center
    to_goal = target - current
    # J_pos, Alg. 1
    onward = straight_on(memory.previous, memory.aim, state.position, center, p.turn_angle == "printed")
    printed = p.position_cost == "printed"
    position_cost = position_costs(
        space.positions, current, target, onward, travelled, p.turn_threshold, p.turn_penalty, printed
    )
    # J_risk, Alg. 2
    sight_distance = SIGHT_SHARE * local_map.half_side
    open_side, printed = space.open_side, p.gap_risk == "printed"
    gap_risk = gap_risks(
        local_map.reach, space.positions, open_side, current, sight_distance, p.gap_weight, p.widest_gap, printed
    )
    approach_risk = np.zeros(len(space.positions))
    if p.approach_risk == "crossing":
        approach_risk = crossings(
            border, local_map.surface, local_map.shadow, space.positions, current, state.velocity, bounds
        )
    predicted = local_map.predicted - np.array([center[0], center[1], 0.0, 0.0])
    collision_risk, distance, line = collision_risks(space.points, space.velocities, predicted, model)
    # J_vel, eq. (2) and (3)
    reward = np.zeros(len(space.points))
    if p.rebound_reward:
        reward = rebound_rewards(space.points, space.velocities, distance, line, predicted, border, to_goal, model)
    goal_vector = unit_vector(to_goal) if p.goal_vector == "unit" else to_goal
    velocity_cost = velocity_costs(space.velocities, goal_vector, collision_risk, reward, p.collision_factor)
    return weighted_terms(
        space.position_of, position_cost, gap_risk, approach_risk, collision_risk, reward, velocity_cost, model
    )


def _least(costs: np.ndarray, space: SamplingSpace, current: np.ndarray, model: CostModel, settings: Settings) -> int:
    """The candidate of least cost (c,); where w_v = 0 leaves the speed undetermined, the tie rule chooses."""
    least = least_first if model.velocity_weight else LEAST_WHERE_SPEED_IS_FREE[settings.planner.tie_rule]
    return least(costs, space.points, space.velocities, current, settings.robot.max_speed)
