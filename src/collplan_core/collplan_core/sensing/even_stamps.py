"""Even stamps for poses that arrive in bursts: a camera's rate is steady, its messages' way to this computer is not."""

EARLY, LATE = 0.3, 0.02
"""Share of a pose's deviation by which the even stamps follow it: a pose may wait on its way, but is never early."""
LOST = 0.5
"""After such a deviation the stamps begin anew [s]."""


def even_stamp(last: float, received: float, period: float) -> float:
    """Returns the stamp [s] of a pose that was received at a time [s], one period [s] after the stamp `last`."""
    expected = last + period
    deviation = received - expected
    if not abs(deviation) <= LOST:
        return received
    return expected + (EARLY if deviation < 0.0 else LATE) * deviation
