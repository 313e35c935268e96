"""The spring and the damper of a compliant ring, from how long it touches in a hit and what comes back."""

from functools import lru_cache
from math import atan, atanh, log, pi

from scipy.optimize import brentq

LEAST_RESTITUTION, MOST_RESTITUTION = 0.01, 0.999
"""Restitutions beyond are taken as these: with none at all the damper would have no end."""
SMALL = 1e-9


@lru_cache(maxsize=1024)
def spring_and_damper(contact_time: float, restitution: float) -> tuple[float, float]:
    """Stiffness [1/s^2] and damping [1/s], both by mass, of a linear ring in a hit head-on.

    Nothing sticks: the hit ends when the force is zero, which is before the ring has its shape back.
    Schwager and Poeschel 2007: Coefficient of restitution and linear-dashpot model revisited.
    """
    loss = -log(min(max(restitution, LEAST_RESTITUTION), MOST_RESTITUTION))
    return (loss**2 + _square_phase(loss)) / contact_time**2, 2.0 * loss / contact_time


def _square_phase(loss: float) -> float:
    """Square of the phase that the oscillation goes through in a hit; negative where it is overdamped."""
    if abs(loss - 2.0) < SMALL:
        return 0.0
    if loss < 2.0:
        return float(brentq(lambda phase: phase - 2.0 * atan(phase / loss), SMALL, pi)) ** 2
    return -(float(brentq(lambda phase: phase - 2.0 * atanh(phase / loss), SMALL, loss * (1.0 - SMALL))) ** 2)
