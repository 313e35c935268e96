"""A time that no disc can beat that does not touch: a closed form, along one axis, rest to rest over the tips."""

import math
from collections.abc import Iterable
from itertools import pairwise

from optimum.disc import Disc
from optimum.free_chain import FreeChain


def lower_bound(chain: FreeChain, disc: Disc) -> float:
    """Time [s] that a disc needs at the least from rest at the start of a free chain to its goal.

    The centre is in each box of the chain in turn, and at the goal then. Of one axis alone: where it must go up and
    later down again, the coordinate has an extreme in between, where its velocity is zero, and which lies at least as
    far as that box. From extreme to extreme it takes at least the shortest time from rest to rest, from the last one
    to the goal that from rest, at any velocity. The larger of the two axes' times; all else is dropped, so that
    the bound is near the optimum only where the way turns back.
    """
    boxes = [region for region in chain.regions if region.vertex is None]
    times = []
    for axis in (0, 1):
        visits = [(float(box.low[axis]), float(box.high[axis])) for box in boxes]
        goal = float(chain.goal[axis])
        visits.append((goal - disc.goal_tolerance, goal + disc.goal_tolerance))
        *legs, last = (abs(b - a) for a, b in pairwise(turning_points(float(chain.start[axis]), visits)))
        limits = disc.max_speed, disc.max_acceleration
        times.append(sum(rest_to_rest(leg, *limits) for leg in legs) + rest_to_free(last, *limits))
    return max(times)


def turning_points(begin: float, visits: Iterable[tuple[float, float]]) -> list[float]:
    """Where a point on a line turns that visits intervals (low, high) in this order and goes no farther than it must.

    From its begin to its end, these included: at least two numbers, which are equal where it need not move.
    """
    points = [begin, begin]
    for low, high in visits:
        at = points[-1]
        reached = min(max(at, low), high)
        if (at - points[-2]) * (reached - at) < 0.0:
            points.append(reached)
        else:
            points[-1] = reached
    return points


def rest_to_rest(distance: float, max_speed: float, max_acceleration: float) -> float:
    """Shortest time [s] over a distance [m] from rest to rest: full acceleration, full speed, full braking."""
    if distance <= max_speed**2 / max_acceleration:
        return 2.0 * math.sqrt(distance / max_acceleration)
    return distance / max_speed + max_speed / max_acceleration


def rest_to_free(distance: float, max_speed: float, max_acceleration: float) -> float:
    """Shortest time [s] over a distance [m] from rest to any velocity: half of that over twice the way to rest."""
    return rest_to_rest(2.0 * distance, max_speed, max_acceleration) / 2.0
