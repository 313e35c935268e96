"""Whether a reported hit calls for a plan at once."""

import math

from collplan_core.state import State


class ImpactAlarm:
    """A hit is planned for at once, from the first pose that knows of it; a hit of another time is not.

    Neither is each one of a flood: the pause between two plans of this kind leaves time for the poses and for the plans
    that are due anyway.
    """

    def __init__(self) -> None:
        """No hit yet."""
        self._awaited: float | None = None
        self._last = -math.inf

    def raised(self, stamp: float, local: float, pause: float) -> str:
        """A hit at `stamp` [s], heard of at `local` [s, local clock]: why no plan is made for it, "" where one is."""
        if local - self._last < pause:
            return f"an impact {local - self._last:.3f} s after the last one planned for, expected at least {pause:g} s"
        self._awaited, self._last = stamp, local
        return ""

    def is_due(self, state: State | None) -> bool:
        """Whether the newest pose knows of the hit, so that the plan is to be made now; told once."""
        if self._awaited is None or state is None or state.stamp < self._awaited:
            return False
        self._awaited = None
        return True

    def forget(self) -> None:
        """The hit no longer matters: the poses broke."""
        self._awaited = None


def why_not_now(stamp: float, now: float | None, limit: float) -> str:
    """Why a hit at `stamp` cannot be one of now, "" where it can.

    Args:
        now: time on the poses' clock, None before the first pose [s].
        limit: largest difference between the two [s].
    """
    if now is None:
        return "an impact before the first pose"
    return "" if abs(stamp - now) <= limit else f"an impact at {stamp:.3f}, expected within {limit:g} s of {now:.3f}"
