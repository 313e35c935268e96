"""The best trajectory of a disc through a free chain, as a nonlinear program that IPOPT solves; needs CasADi.

The acceleration is constant in each interval and integrated exactly. The intervals of a region have one length, which
the solver chooses, so that the trajectory spends in each region the time that suits it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import pairwise
from typing import Any

import numpy as np

from collplan_study.errors import StudyError
from optimum.disc import Disc
from optimum.free_chain import FreeChain, Region

BOX_INTERVALS, PER_LENGTH = 14, 14 / 0.9
"""Intervals in a box, at least, and for each metre of its longer side."""
CORNER_INTERVALS = 8
SHORTEST_STAY, LONGEST_STAY = 1e-4, 60.0
"""In each region [s]; not zero, so that the program stays regular where a region is left at once."""
GUESSED_SPEED = 0.5
"""Of the initial guesses [m/s]."""
GUESSED_OFFSETS = (0.1, 0.7)
"""Where each initial guess passes a turn: 0 is as near to the tip as can be, 1 in the middle of the corridor."""
IPOPT = {"ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.max_iter": 2000, "print_time": False}


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Motion at constant acceleration from knot to knot, from rest to the goal."""

    times: np.ndarray  # (n,) from 0 to the arrival [s]
    positions: np.ndarray  # (n, 2) there [m]
    velocities: np.ndarray  # (n, 2) there [m/s]
    accelerations: np.ndarray  # (n - 1, 2) from each knot to the next [m/s^2]

    @property
    def duration(self) -> float:
        """[s]."""
        return float(self.times[-1])


def check_installed() -> None:
    """Raises StudyError where CasADi is missing."""
    if find_spec("casadi") is None:
        raise StudyError("CasADi is not installed: call make optimum, whose environment has it, or pip install casadi")


def best_trajectories(chain: FreeChain, disc: Disc) -> tuple[Trajectory, ...]:
    """The best trajectories found from rest at the start of a free chain to its goal, fastest first.

    One for each initial guess from which the solver converges. Each is locally optimal, so that the optimum is at most
    as long. Speed and acceleration keep their limits at any time, walls are kept at the knots and half-way between.
    """
    mesh = _mesh(chain.regions)
    solver, limits = _program(mesh, chain, disc)
    found = []
    for offset in GUESSED_OFFSETS:
        solution = solver(x0=_guess(mesh, chain, offset), **limits)
        if solver.stats()["success"]:
            found.append(_trajectory(mesh, solution["x"].full().ravel()))
    return tuple(sorted(found, key=lambda each: each.duration))


@dataclass(frozen=True, eq=False)
class _Mesh:
    """The intervals of a trajectory."""

    counts: np.ndarray  # (k,) number of intervals in each region
    firsts: np.ndarray  # (k,) first of them
    regions: np.ndarray  # (n,) region of each interval


def _mesh(regions: Sequence[Region]) -> _Mesh:
    counts = np.array([_intervals(region) for region in regions])
    return _Mesh(counts, np.cumsum(counts) - counts, np.repeat(np.arange(len(regions)), counts))


def _intervals(region: Region) -> int:
    if region.vertex is not None:
        return CORNER_INTERVALS
    return max(BOX_INTERVALS, math.ceil(PER_LENGTH * float((region.high - region.low).max())))


def _program(mesh: _Mesh, chain: FreeChain, disc: Disc) -> tuple[Any, dict[str, np.ndarray]]:
    """The solver, and the bounds of variables and constraints that it takes."""
    import casadi

    k, n = len(mesh.counts), len(mesh.regions)
    stays = casadi.SX.sym("stay", 1, k)
    p, v = casadi.SX.sym("p", 2, n + 1), casadi.SX.sym("v", 2, n + 1)
    a = casadi.SX.sym("a", 2, n)
    counts = casadi.DM(mesh.counts[mesh.regions].astype(float)).T
    step = casadi.repmat(stays[0, mesh.regions.tolist()] / counts, 2, 1)
    middle = p[:, :-1] + v[:, :-1] * step / 2 + a * step**2 / 8
    low, high = (np.array([getattr(region, end) for region in chain.regions]) for end in ("low", "high"))

    constraints: list[tuple[Any, Any, Any]] = [
        (p[:, 1:] - p[:, :-1] - v[:, :-1] * step - a * step**2 / 2, 0.0, 0.0),
        (v[:, 1:] - v[:, :-1] - a * step, 0.0, 0.0),
        (casadi.sum1(a**2), -np.inf, disc.max_acceleration**2),
        # enough at the knots: between them the velocity changes along a straight line
        (casadi.sum1(v**2), -np.inf, disc.max_speed**2),
        (middle, low[mesh.regions].ravel(), high[mesh.regions].ravel()),
        (casadi.sum1((p[:, n] - casadi.DM(chain.goal)) ** 2), -np.inf, disc.goal_tolerance**2),
    ]
    for region, first, count in zip(chain.regions, mesh.firsts.tolist(), mesh.counts.tolist(), strict=True):
        if region.vertex is not None:
            points = casadi.horzcat(p[:, first : first + count + 1], middle[:, first : first + count])
            from_vertex = points - casadi.repmat(casadi.DM(region.vertex), 1, 2 * count + 1)
            constraints.append((casadi.sum1(from_vertex**2), disc.radius**2, np.inf))

    # a knot between two regions is in both
    before, after = np.append(mesh.regions[0], mesh.regions), np.append(mesh.regions, mesh.regions[-1])
    lowest, highest = np.maximum(low[before], low[after]), np.minimum(high[before], high[after])
    lowest[0] = highest[0] = chain.start
    fastest = np.full((n + 1, 2), np.inf)
    fastest[0] = 0.0
    unlimited = np.full(2 * n, np.inf)
    program = {
        "x": casadi.vertcat(stays.T, casadi.vec(p), casadi.vec(v), casadi.vec(a)),
        "f": casadi.sum2(stays),
        "g": casadi.vertcat(*(casadi.vec(each) for each, _, _ in constraints)),
    }
    limits = {
        "lbx": _joined(np.full(k, SHORTEST_STAY), lowest, -fastest, -unlimited),
        "ubx": _joined(np.full(k, LONGEST_STAY), highest, fastest, unlimited),
        "lbg": _joined(*(np.broadcast_to(least, each.numel()) for each, least, _ in constraints)),
        "ubg": _joined(*(np.broadcast_to(most, each.numel()) for each, _, most in constraints)),
    }
    return casadi.nlpsol("optimum", "ipopt", program, IPOPT), limits


def _guess(mesh: _Mesh, chain: FreeChain, offset: float) -> np.ndarray:
    """Straight through each region, at one speed."""
    passages = [_passage(one, other, offset) for one, other in pairwise(chain.regions)]
    ends = np.array([chain.start, *passages, chain.goal])
    ways = np.diff(ends, axis=0)
    stays = np.maximum(np.hypot(*ways.T) / GUESSED_SPEED, 2 * SHORTEST_STAY)
    shares = np.concatenate([np.arange(count) / count for count in mesh.counts])
    positions = ends[mesh.regions] + shares[:, None] * ways[mesh.regions]
    velocities = (ways / stays[:, None])[mesh.regions]
    return _joined(
        stays,
        np.vstack([positions, chain.goal]),
        np.vstack([np.zeros(2), velocities[1:], velocities[-1]]),
        np.zeros((len(mesh.regions), 2)),
    )


def _passage(one: Region, other: Region, offset: float) -> np.ndarray:
    """A point (2,) in both of a box and the corner beside it, between the tip and the middle [m]."""
    low, high = np.maximum(one.low, other.low), np.minimum(one.high, other.high)
    vertex = next(region.vertex for region in (one, other) if region.vertex is not None)
    tip = np.clip(vertex, low, high)
    return tip + offset * ((low + high) / 2 - tip)


def _trajectory(mesh: _Mesh, x: np.ndarray) -> Trajectory:
    knots = len(mesh.regions) + 1
    stays, positions, velocities, accelerations = np.split(x, np.cumsum([len(mesh.counts), 2 * knots, 2 * knots]))
    return Trajectory(
        np.append(0.0, np.cumsum((stays / mesh.counts)[mesh.regions])),
        positions.reshape(-1, 2),
        velocities.reshape(-1, 2),
        accelerations.reshape(-1, 2),
    )


def _joined(*parts: np.ndarray) -> np.ndarray:
    return np.concatenate([np.ravel(part) for part in parts])
