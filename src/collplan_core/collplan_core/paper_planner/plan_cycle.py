"""The sampling planner: reading `plan_cycle` top to bottom is reading the paper's II and III-A."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.frontiers import SHADOW_EDGE
from collplan_core.local_map.record import LocalMap
from collplan_core.paper_planner.candidates import long_enough, product, sample_positions, speed_counts
from collplan_core.paper_planner.costs.position import position_costs
from collplan_core.paper_planner.costs.risk import crosses_boundary, gap_risk
from collplan_core.paper_planner.costs.total import TERMS, choose, evaluate
from collplan_core.paper_planner.foreseen_contacts import foreseen_contacts
from collplan_core.paper_planner.pruning import prune_directions, prune_positions
from collplan_core.paper_planner.trajectory import make_trajectory, spline
from collplan_core.parameters import Planning, Settings
from collplan_core.plan import Candidates, NoPlan, Plan
from collplan_core.state import State
from collplan_core.strategies import map_period_of, weights_of

TIE_BREAK = 1e-3  # cost by which a velocity along the approach wins among equals


@dataclass(frozen=True, eq=False)
class PlannerMemory:
    """What one cycle leaves to the next, world frame: p_pre, the aim p_s of then, the way from p_ini to p_pre [m]."""

    previous: np.ndarray
    aim: np.ndarray
    travelled: float


@njit
def _space(segments: np.ndarray, number: np.ndarray, ends: np.ndarray, goal: np.ndarray, spacing: float,
           n_directions: int, n_speeds: int, max_speed: float, prune_distance: float,
           prune_by_position: bool, prune_by_direction: bool, printed_speeds: bool) -> tuple[Any, ...]:  # fmt: skip
    """C after pruning, and its size before. Paper: II-A, II-C."""
    positions, piece = sample_positions(segments, number, spacing)
    counts = speed_counts(piece, number, n_speeds, printed_speeds)
    whole = len(positions) + int(counts.sum()) * n_directions
    kept = np.ones(len(positions), np.bool_)
    if prune_by_position:
        member = np.empty(len(positions), np.int64)
        for i in range(len(positions)):
            member[i] = number[piece[i]]
        kept = prune_positions(ends, positions, member, goal[0], goal[1], prune_distance)
    heads = np.ones((len(segments), n_directions), np.bool_)
    if prune_by_direction:
        heads = prune_directions(segments, n_directions)
    survivors = np.flatnonzero(kept)
    positions, piece, counts = positions[survivors], piece[survivors], counts[survivors]
    at, velocity = product(np.ones(len(survivors), np.bool_), heads, piece, counts, max_speed)
    return positions, piece, at, velocity, whole


@njit
def _position_risks(positions: np.ndarray, piece: np.ndarray, lit: np.ndarray, current: np.ndarray,
                    velocity: np.ndarray, reach: np.ndarray, ends: np.ndarray, surface: np.ndarray,
                    shadow: np.ndarray, far: float, gap_weight: float, widest: float, max_speed: float,
                    printed_gap: bool, printed_approach: bool) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The parts of J_risk that depend on the position alone: J_risk,g and the approach. Paper: Alg. 2."""
    n = len(positions)
    gap, approach = np.zeros(n), np.zeros(n)
    for i in range(n):
        x, y = positions[i]
        from_robot = np.hypot(x - current[0], y - current[1])
        gap[i] = gap_risk(
            reach, x, y, from_robot, lit[piece[i], 0], lit[piece[i], 1], far, gap_weight, widest, printed_gap
        )
        if not printed_approach:
            approach[i] = crosses_boundary(
                ends, surface, shadow, current[0], current[1], velocity[0], velocity[1], x, y, max_speed
            )
    return gap, approach


@njit
def _renumbered(number: np.ndarray) -> np.ndarray:
    """Frontier numbers without gaps."""
    numbers = np.zeros(len(number), np.int64)
    for i in range(1, len(number)):
        numbers[i] = numbers[i - 1] + int(number[i] != number[i - 1])
    return numbers


def _aim_at_frontiers(
    memory: PlannerMemory, local_map: LocalMap, state: State, goal: np.ndarray, settings: Settings
) -> tuple[np.ndarray, np.ndarray, dict[str, float], Candidates, int]:
    """q_s = argmin over C of the objective. Paper: eq. (1)."""
    p, weights = settings.planner, weights_of(settings)
    center, ends = local_map.position, local_map.ends
    used = (
        local_map.frontier_kind == SHADOW_EDGE if p.frontiers == "printed" else np.ones(len(local_map.segments), bool)
    )
    used &= long_enough(local_map.segments, local_map.frontier_number, p.shortest_frontier)
    if not used.any():
        raise NoPlan("no frontier in the local map and the goal is not in free space")
    lit = local_map.lit[used]
    current, target = state.position - center, goal - center
    positions, piece, at, velocity, whole = _space(
        local_map.segments[used] - np.concatenate([center, center]), _renumbered(local_map.frontier_number[used]),
        ends, target, p.frontier_spacing, p.n_directions, p.n_speeds, settings.robot.max_speed, p.prune_distance,
        p.position_pruning, p.velocity_pruning, p.speeds == "printed",
    )  # fmt: skip
    has_previous = not np.isnan(memory.aim).any()
    j_pos = position_costs(
        positions, current, target, memory.aim - memory.previous, memory.previous - center,
        memory.travelled + float(np.hypot(*(state.position - memory.previous))), has_previous,
        p.turn_threshold, p.turn_penalty, p.turn_angle == "printed", p.position_cost == "printed",
    )  # fmt: skip
    gap, approach = _position_risks(
        positions, piece, lit, current, state.velocity, local_map.reach, ends, local_map.surface, local_map.shadow,
        settings.local_map.sight_share * local_map.half_side, p.gap_weight, p.widest_gap, settings.robot.max_speed,
        p.gap_risk == "printed", p.approach_risk == "printed",
    )  # fmt: skip
    predicted = local_map.predicted - np.array([center[0], center[1], 0.0, 0.0])
    terms = evaluate(
        positions, at, velocity, j_pos, gap, approach, current, target, ends, predicted,
        np.array([weights.position, weights.risk, weights.velocity]), p.speed_floor, p.time_floor,
        settings.rebound.restitution, settings.rebound.tangential_retention, p.rebound_horizon, p.rebound_penalty,
        p.goal_vector == "unit", p.rebound_reward, p.collision_factor,
    )  # fmt: skip
    forward = TIE_BREAK if p.tie_rule == "forward" and weights.velocity == 0.0 else 0.0
    best = choose(terms, positions, at, velocity, current, settings.robot.max_speed, forward)
    candidates = Candidates(positions[at] + center, velocity, terms[:, 0])
    return (
        positions[at[best]] + center,
        velocity[best],
        dict(zip(TERMS, terms[best].tolist(), strict=True)),
        candidates,
        whole,
    )


def _trajectory(
    state: State, aim: np.ndarray, aim_velocity: np.ndarray, settings: Settings
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times from 0 (n,), positions (n, 2) and velocities (n, 2) of the spline to the aim. Paper: III-A."""
    p: Planning = settings.planner
    points, duration = make_trajectory(
        state.position, state.velocity, aim, aim_velocity, settings.robot.max_speed, map_period_of(settings),
        p.time_scale, p.acceleration_factor * settings.robot.max_acceleration, p.waypoints == "chord",
        p.time_law == "printed",
    )  # fmt: skip
    share = np.arange(p.n_samples) / (p.n_samples - 1)
    positions, derivative = spline(points, share)
    return share * duration, positions, derivative / duration


def plan_cycle(memory: PlannerMemory | None, local_map: LocalMap, state: State, goal: np.ndarray,
               settings: Settings) -> tuple[Plan, PlannerMemory]:  # fmt: skip
    """One cycle of the paper's planner: from a local map to a timed reference.

    Args:
        memory: what the previous cycle left, None at the start and after a new goal.
        state: the robot at the scan's stamp.
        goal: (2,) p_goal [m].

    Raises:
        NoPlan: the goal is not in F and F has no frontier.
    """
    # own copies: a read-only array is another type to the compiler, and would be compiled for once more
    state = replace(state, position=np.array(state.position), velocity=np.array(state.velocity))
    goal, nothing = np.array(goal, dtype=float), np.full(2, np.nan)
    memory = memory or PlannerMemory(state.position, nothing, 0.0)
    if local_map.contains(goal)[0]:
        aim, aim_velocity = goal, np.zeros(2)
        terms: dict[str, float] = dict.fromkeys(TERMS, 0.0)
        candidates, whole = Candidates(aim[None], aim_velocity[None], np.zeros(1)), 1
        seen_aim = nothing
    else:
        aim, aim_velocity, terms, candidates, whole = _aim_at_frontiers(memory, local_map, state, goal, settings)
        seen_aim = aim
    times, positions, velocities = _trajectory(state, aim, aim_velocity, settings)
    plan = Plan(
        stamp=local_map.stamp, times=local_map.stamp + times, positions=positions, velocities=velocities,
        contacts=foreseen_contacts(local_map, local_map.stamp + times, positions, velocities, settings),
        aim=aim, aim_velocity=aim_velocity, terms=terms, candidates=candidates, n_before_pruning=whole,
    )  # fmt: skip
    way = memory.travelled + float(np.hypot(*(state.position - memory.previous)))
    return plan, PlannerMemory(state.position, seen_aim, way)
