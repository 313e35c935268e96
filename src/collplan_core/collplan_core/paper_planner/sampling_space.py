"""The sampling configuration space C of a local map, pruned. Paper: II-A and II-C."""

from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.frontiers import SHADOW_EDGE
from collplan_core.local_map.record import LocalMap
from collplan_core.paper_planner.candidates import SPEED_COUNTS, long_enough, product, sample_positions
from collplan_core.paper_planner.pruning import prune_directions, prune_positions
from collplan_core.parameters import Planning
from collplan_core.parameters.groups import RADIUS
from collplan_core.velocity_bounds import VelocityBounds

PRUNE_DISTANCE = 0.35
"""d_prune of a robot of RADIUS, in proportion to the radius: within it one frontier represents another [m]."""


class SamplingSpace(NamedTuple):
    """C after pruning, relative to the centre of F."""

    positions: np.ndarray  # (p, 2) the positions S [m]
    open_side: np.ndarray  # (p, 2) whether F is seen to be open clockwise, counter-clockwise of each one's frontier
    position_of: np.ndarray  # (c,) the position of each candidate
    points: np.ndarray  # (c, 2) p_s of each candidate [m]
    velocities: np.ndarray  # (c, 2) v_s of each candidate [m/s]
    n_before_pruning: int  # size of C before pruning


def all_frontiers(local_map: LocalMap) -> np.ndarray:
    """(m,) every frontier segment: shadow edges and visible runs of the map's border."""
    return np.ones(len(local_map.segments), np.bool_)


def shadow_edges(local_map: LocalMap) -> np.ndarray:
    """(m,) which frontier segments are shadow edges: obstacle-extending frontiers alone, as printed."""
    return local_map.frontier_kind == SHADOW_EDGE


FRONTIERS = {"all": all_frontiers, "printed": shadow_edges}
"""Frontiers on which candidates may lie, by planner.frontiers."""


class _Samples(NamedTuple):
    """S and the frontiers, numbered from 0, relative to the centre of F."""

    segments: np.ndarray  # (m, 4) the frontier segments [m]
    open_side: np.ndarray  # (m, 2) their open sides
    positions: np.ndarray  # (p, 2) [m]
    segment_of: np.ndarray  # (p,) segment of each position
    frontier_of: np.ndarray  # (p,) frontier of each position


@njit
def _sampled(
    segments: np.ndarray,
    number: np.ndarray,
    open_side: np.ndarray,
    eligible: np.ndarray,
    center: np.ndarray,
    shortest: float,
    spacing: float,
) -> _Samples:
    """S on the eligible frontiers that are long enough."""
    index = np.flatnonzero(eligible & long_enough(segments, number, shortest))
    chosen, numbers = np.empty((len(index), 4)), np.zeros(len(index), np.int64)
    for i in range(len(index)):
        for a in range(4):
            chosen[i, a] = segments[index[i], a] - center[a % 2]
        if i > 0:
            numbers[i] = numbers[i - 1] + int(number[index[i]] != number[index[i - 1]])
    positions, segment_of = sample_positions(chosen, numbers, spacing)
    return _Samples(chosen, open_side[index], positions, segment_of, numbers[segment_of])


class _Rule(NamedTuple):
    """Rule by which C is built from S: N_l, v_max by direction, d_prune [m], and which prunings apply."""

    n_directions: int
    bounds: VelocityBounds
    prune_distance: float
    by_position: bool
    by_direction: bool


@njit
def _pruned(
    samples: _Samples, n_speeds: np.ndarray, border: np.ndarray, goal: np.ndarray, rule: _Rule
) -> SamplingSpace:
    """C of the samples at N_v speeds (p,), without what pruning drops. Paper: II-C."""
    n_before_pruning = len(samples.positions) + int(n_speeds.sum()) * rule.n_directions
    kept = np.ones(len(samples.positions), np.bool_)
    if rule.by_position:
        kept = prune_positions(border, samples.positions, samples.frontier_of, goal, rule.prune_distance)
    directions = np.ones((len(samples.segments), rule.n_directions), np.bool_)
    if rule.by_direction:
        directions = prune_directions(samples.segments, rule.n_directions)
    positions, segment_of = samples.positions[kept], samples.segment_of[kept]
    position_of, velocities = product(directions, segment_of, n_speeds[kept], rule.bounds)
    open_side = samples.open_side[segment_of]
    return SamplingSpace(positions, open_side, position_of, positions[position_of], velocities, n_before_pruning)


def sampling_space(local_map: LocalMap, goal: np.ndarray, bounds: VelocityBounds, planner: Planning) -> SamplingSpace:
    """C after pruning; empty where the local map has no frontier to aim at. Paper: II-A and II-C.

    The goal (2,), p_goal, is relative to the centre of F [m]; `bounds` are v_max by direction.
    """
    samples = _sampled(
        local_map.segments,
        local_map.frontier_number,
        local_map.open_side,
        FRONTIERS[planner.frontiers](local_map),
        local_map.position,
        planner.shortest_frontier,
        planner.frontier_spacing,
    )
    n_speeds = SPEED_COUNTS[planner.speeds](samples.frontier_of, planner.n_speeds)
    d_prune = PRUNE_DISTANCE * (local_map.radius / RADIUS)
    rule = _Rule(planner.n_directions, bounds, d_prune, planner.position_pruning, planner.velocity_pruning)
    return _pruned(samples, n_speeds, local_map.border, goal, rule)
