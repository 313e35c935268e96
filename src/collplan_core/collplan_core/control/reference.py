"""The reference that a plan gives the controller: where to be when, how fast, and where its velocity turns."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.plan import Plan

KINK_FACTOR, KINK_SPEED = 1.3, 0.08
"""A path without velocities turns where its velocity changes by more than this factor of what the wheels make, and
this speed [m/s]."""


class Reference(NamedTuple):
    """A timed path with contacts."""

    times: np.ndarray  # (n,) strictly rising [s]
    positions: np.ndarray  # (n, 2) [m]
    velocities: np.ndarray  # (n, 2) [m/s]; at a turn, that after it
    turns: np.ndarray  # (k,) indices of the samples at which the velocity jumps, none of them the first or last


def planned_reference(plan: Plan, max_acceleration: float) -> Reference:
    """The reference of a plan. It turns at each contact after which the path has the contact's velocity.

    The paper's plans also foresee contacts behind which the path goes straight on. The reference does not turn there.
    For a plan without velocities, `found_reference` finds the turns from `max_acceleration` [m/s^2].
    """
    if plan.velocities is None:
        return found_reference(plan.times, plan.positions, max_acceleration)
    turns = _turns(plan.times, plan.positions, plan.velocities, plan.contacts.times, plan.contacts.velocities_after)
    return _with_velocities(plan.times, plan.positions, turns)


@njit
def _turns(
    times: np.ndarray, positions: np.ndarray, velocities: np.ndarray, contacts: np.ndarray, after: np.ndarray
) -> np.ndarray:
    """Indices of the samples at contacts, times (k,) [s], after which a path has their velocities `after` (k, 2)."""
    turns = np.zeros(len(times), np.bool_)
    for k in range(len(contacts)):
        j = int(np.abs(times - contacts[k]).argmin())
        if not 0 < j < len(times) - 1:
            continue
        x, y = (positions[j + 1] - positions[j]) / (times[j + 1] - times[j])
        vx, vy = velocities[j - 1]
        if math.hypot(x - after[k, 0], y - after[k, 1]) < math.hypot(x - vx, y - vy):
            turns[j] = True
    return np.flatnonzero(turns)


def found_reference(times: np.ndarray, positions: np.ndarray, max_acceleration: float) -> Reference:
    """The reference of a path alone: times (n,) [s], positions (n, 2) [m]; it turns where the wheels could not."""
    steps = np.diff(positions, axis=0) / np.diff(times)[:, None]
    jumps = np.hypot(*np.diff(steps, axis=0).T)
    made = max_acceleration * 0.5 * (times[2:] - times[:-2])
    return _with_velocities(times, positions, 1 + np.flatnonzero(jumps > KINK_FACTOR * made + KINK_SPEED))


@njit
def _with_velocities(times: np.ndarray, positions: np.ndarray, turns: np.ndarray) -> Reference:
    """The reference with the velocities that its positions have between turns, linear between the middles of steps."""
    # A plan's own, which differ where its acceleration jumps, drive the robot slower: by 1 % in 24 serpentines.
    velocities, first = np.empty((len(times), 2)), 0
    for number in range(len(turns) + 1):
        last = turns[number] if number < len(turns) else len(times) - 1
        # straight on beyond the first and last middle
        i = first
        for k in range(first, last + 1):
            while i < last - 2 and 0.5 * (times[i + 1] + times[i + 2]) < times[k]:
                i += 1
            for c in range(2):
                velocities[k, c] = (positions[i + 1, c] - positions[i, c]) / (times[i + 1] - times[i])
                if last - first > 1:
                    onward = (positions[i + 2, c] - positions[i + 1, c]) / (times[i + 2] - times[i + 1])
                    middle, after = 0.5 * (times[i] + times[i + 1]), 0.5 * (times[i + 1] + times[i + 2])
                    velocities[k, c] += (times[k] - middle) / (after - middle) * (onward - velocities[k, c])
        first = last
    return Reference(times, positions, velocities, turns)


def sample_reference(reference: Reference, now: float) -> tuple[np.ndarray, np.ndarray]:
    """Position (2,) and velocity (2,) of a reference now [s]; at rest at the end once the time is past."""
    x, y, vx, vy = _sampled(tuple(reference), now)
    return np.array((x, y)), np.array((vx, vy))


@njit
def _sampled(fields: tuple, now: float) -> tuple[float, float, float, float]:
    """Position and velocity of the reference with these fields, which cost less to hand over than the reference."""
    reference = Reference(*fields)
    times, x = reference.times, reference.positions
    if now > times[-1]:
        return x[-1, 0], x[-1, 1], 0.0, 0.0
    k = sample_before(times, now)
    vx, vy = velocity_at(reference, *stretch_at(reference, k), now)
    if now == times[-1]:
        return x[-1, 0], x[-1, 1], vx, vy
    span, since = times[k + 1] - times[k], max(now - times[k], 0.0)
    px, py = (x[k + 1, 0] - x[k, 0]) / span * since + x[k, 0], (x[k + 1, 1] - x[k, 1]) / span * since + x[k, 1]
    return px, py, vx, vy


@njit
def sample_before(times: np.ndarray, time: float) -> int:
    """The last sample at or before a time, or the one from which the path goes on to its end."""
    return min(max(int(np.searchsorted(times, time, side="right")) - 1, 0), len(times) - 2)


@njit
def stretch_at(reference: Reference, sample: int) -> tuple[int, int]:
    """First and last sample of the stretch without a turn that goes on from a sample."""
    first, last = 0, len(reference.times) - 1
    for turn in reference.turns:
        if turn <= sample:
            first = turn
        elif turn < last:
            last = turn
    return first, last


@njit
def velocity_at(reference: Reference, first: int, last: int, time: float) -> tuple[float, float]:
    """Velocity at a time on the stretch from sample `first` to `last`, up to the turn at its end."""
    times, x, v = reference.times, reference.positions, reference.velocities
    i = min(max(int(np.searchsorted(times, time, side="right")) - 1, first), last - 1)
    span = times[i + 1] - times[i]
    share = min(max((time - times[i]) / span, 0.0), 1.0)
    wx, wy = v[i + 1, 0], v[i + 1, 1]
    if i + 1 == last and last < len(times) - 1:
        # the velocity before the turn, which its sample has no more
        wx, wy = 2.0 * (x[last, 0] - x[i, 0]) / span - v[i, 0], 2.0 * (x[last, 1] - x[i, 1]) / span - v[i, 1]
    return v[i, 0] + share * (wx - v[i, 0]), v[i, 1] + share * (wy - v[i, 1])
