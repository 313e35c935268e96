"""Alarm of a reported impact, which requires replanning at once, outside the planning period."""

import math

from collplan_core.state import State


class ImpactAlarm:
    """Requests one plan per impact, made from the first pose whose velocity is that after the impact.

    Impacts that follow each other within a pause are refused: a flood of them must leave time for poses and for the
    plans that are due anyway.
    """

    def __init__(self) -> None:
        """Starts without an impact."""
        self._awaited: float | None = None
        self._last = -math.inf

    def raised(self, stamp: float, local: float, pause: float) -> str:
        """Registers an impact; returns the reason why it is refused, or "" where a plan will be made for it.

        Its stamp is on the poses' clock [s], its receipt, `local`, on the local one [s]; `pause` is the shortest time
        between two plans of this kind [s].
        """
        if local - self._last < pause:
            return f"an impact {local - self._last:.3f} s after the last one planned for, expected at least {pause:g} s"
        self._awaited, self._last = stamp, local
        return ""

    def is_due(self, state: State | None) -> bool:
        """Returns whether to plan now: the newest pose is as late as the registered impact. True once per impact."""
        if self._awaited is None or state is None or state.stamp < self._awaited:
            return False
        self._awaited = None
        return True

    def forget(self) -> None:
        """Drops a registered impact, for instance after a break in the poses."""
        self._awaited = None


def why_not_now(stamp: float, now: float | None, limit: float) -> str:
    """Returns the reason why an impact with this stamp [s] is implausible now; "" where it is plausible.

    Both are on the poses' clock [s], `now` None before the first pose; they may differ by at most `limit` [s].
    """
    if now is None:
        return "an impact before the first pose"
    return "" if abs(stamp - now) <= limit else f"an impact at {stamp:.3f}, expected within {limit:g} s of {now:.3f}"
