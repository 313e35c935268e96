"""The command that drives a robot with a lag along a reference with contacts."""

import math

from collplan_core.control.reference import Reference, sample_before, stretch_at, velocity_at
from collplan_core.jit import njit
from collplan_core.velocity_bounds import VelocityBounds, room_along
from collplan_core.velocity_law import VelocityLaw, command_lead

FULL, TOO_MUCH = 0.93, 1.02
"""A change of velocity between these shares of what the wheels can make takes full acceleration throughout."""


def feed_forward(
    reference: Reference, now: float, period: float, wheels: VelocityLaw, bounds: VelocityBounds, lead: float
) -> tuple[float, float]:
    """Returns the command that, held for `period` [s] from now [s] on, makes a robot with a lag drive a reference.

    Where the path takes full acceleration throughout, how far the command leads the velocity does not matter to a robot
    without errors. An error of the velocity aimed at turns it the less, the farther that is: there it leads by up to
    `lead` [m/s], as far as the bounds allow.

    A period in which the reference turns, at a contact, belongs to its longer part. Something between both would brake
    before the contact and push back after it.
    """
    ux, uy = _feed_forward(tuple(reference), now, period, tuple(wheels), tuple(bounds), lead)
    return ux, uy


@njit
def _feed_forward(
    reference_fields: tuple, now: float, period: float, wheels_fields: tuple, bounds_fields: tuple, lead: float
) -> tuple[float, float]:
    """The same with plain tuples, which cost a fifth of named ones to hand over."""
    reference, wheels = Reference(*reference_fields), VelocityLaw(*wheels_fields)
    bounds = VelocityBounds(*bounds_fields)
    times = reference.times
    n = len(times)
    ux, uy, longest = 0.0, 0.0, 0.0
    i, begin = sample_before(times, now), now
    while i < n - 1 and begin < now + period:
        first, last = stretch_at(reference, i)
        until = min(times[last], now + period)
        if until - begin > longest:
            longest = until - begin
            ax, ay = velocity_at(reference, first, last, begin)
            bx, by = velocity_at(reference, first, last, until)
            change = math.hypot(bx - ax, by - ay)
            ux, uy = ax, ay
            if change > 1e-9:
                dx, dy, ahead = (bx - ax) / change, (by - ay) / change, command_lead(wheels, change, longest)
                if FULL < change / (wheels.max_acceleration * longest) < TOO_MUCH:
                    ahead = max(ahead, min(lead, room_along(bounds, ax, ay, dx, dy)))
                ux, uy = ax + ahead * dx, ay + ahead * dy
        begin = max(begin, until)
        i = last
    return ux, uy
