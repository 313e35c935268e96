"""The reference that a plan gives the controller: where to be when, how fast, and where its velocity turns."""

from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.plan import Plan

KINK_FACTOR, KINK_SPEED = 1.3, 0.08
"""A path without velocities turns where its velocity changes by more than this factor of what the wheels make, and
this speed [m/s]."""


class Reference(NamedTuple):
    """A timed path with contacts.

    Attributes:
        times: (n,) strictly rising [s].
        positions: (n, 2) [m].
        velocities: (n, 2) [m/s]; at a turn, that after it.
        turns: (k,) indices of the samples at which the velocity jumps, none of them the first or last.
    """

    times: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray
    turns: np.ndarray


def planned_reference(plan: Plan, max_acceleration: float) -> Reference:
    """The reference of a plan. It turns at each contact after which the path has the contact's velocity.

    The paper's plans also foresee contacts behind which the path goes straight on. The reference does not turn there.
    For a plan without velocities, `found_reference` finds the turns from `max_acceleration` [m/s^2].
    """
    if plan.velocities is None:
        return found_reference(plan.times, plan.positions, max_acceleration)
    times, positions = plan.times, plan.positions
    turns = set()
    for time, after in zip(plan.contacts.times, plan.contacts.velocities_after, strict=True):
        j = int(np.abs(times - time).argmin())
        if not 0 < j < len(times) - 1:
            continue
        onward = (positions[j + 1] - positions[j]) / (times[j + 1] - times[j])
        if np.hypot(*(onward - after)) < np.hypot(*(onward - plan.velocities[j - 1])):
            turns.add(j)
    return _with_velocities(times, positions, np.array(sorted(turns), dtype=np.int64))


def found_reference(times: np.ndarray, positions: np.ndarray, max_acceleration: float) -> Reference:
    """The reference of a path alone: times (n,) [s], positions (n, 2) [m]; it turns where the wheels could not."""
    steps = np.diff(positions, axis=0) / np.diff(times)[:, None]
    jumps = np.hypot(*np.diff(steps, axis=0).T)
    made = max_acceleration * 0.5 * (times[2:] - times[:-2])
    return _with_velocities(times, positions, 1 + np.flatnonzero(jumps > KINK_FACTOR * made + KINK_SPEED))


def _with_velocities(times: np.ndarray, positions: np.ndarray, turns: np.ndarray) -> Reference:
    """The reference with the velocities that its positions have on each stretch between two turns.

    They are those of the steps at their middles, and linear between. A plan's own, which differ where its acceleration
    jumps, drive the robot slower: by 1 % in 24 serpentines.
    """
    steps = np.diff(positions, axis=0) / np.diff(times)[:, None]
    velocities = np.empty_like(positions)
    for first, last in zip([0, *turns], [*turns, len(times) - 1], strict=True):
        middles = 0.5 * (times[first:last] + times[first + 1 : last + 1])
        smooth, own = steps[first:last], times[first : last + 1]
        if len(smooth) == 1:
            velocities[first : last + 1] = smooth
            continue
        # straight on beyond the first and last middle
        i = np.clip(np.searchsorted(middles, own) - 1, 0, len(smooth) - 2)
        share = ((own - middles[i]) / (middles[i + 1] - middles[i]))[:, None]
        velocities[first : last + 1] = smooth[i] + share * (smooth[i + 1] - smooth[i])
    return Reference(times, positions, velocities, turns)


def sample_reference(reference: Reference, now: float) -> tuple[np.ndarray, np.ndarray]:
    """Position (2,) and velocity (2,) of a reference now [s]; at rest at the end once the time is past."""
    times, positions = reference.times, reference.positions
    position = np.array([np.interp(now, times, positions[:, axis]) for axis in range(2)])
    if now > times[-1]:
        return position, np.zeros(2)
    return position, np.array(velocity_at(reference, *stretch_at(reference, sample_before(times, now)), now))


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
