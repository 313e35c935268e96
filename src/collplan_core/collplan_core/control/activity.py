"""Description of what the controller is doing, for people and records; nothing is decided by it."""

import re
from dataclasses import dataclass

import numpy as np

from collplan_core.command import BOUNDARY_FOLLOWING, FLOW_THROUGH, HAND, STOPPED, WAITING, Command
from collplan_core.evaluation.impact_matching import TIME_TOLERANCE
from collplan_core.plan import Contacts, Plan

BOUNCE = "bounce"
TRACK = "track"
MANEUVER = "maneuver"
ACTIVITIES = (BOUNCE, TRACK, MANEUVER, HAND, STOPPED)

MANEUVER_REASONS = {
    BOUNDARY_FOLLOWING: "follows the boundary that the plan runs into",
    FLOW_THROUGH: "flows through on the chord of the plan, which runs into a boundary",
}


@dataclass(frozen=True)
class Activity:
    """Activity of the controller: its name and the reason.

    Attributes:
        name: one of ACTIVITIES. BOUNCE: it drives into a contact that the plan foresees, or just did; TRACK: it follows
            the plan elsewhere; MANEUVER: it leaves the plan for a maneuver at a boundary; HAND: a person drives;
            STOPPED.
        reason: the reason in a few words.
    """

    name: str
    reason: str

    def differs(self, other: "Activity | None") -> bool:
        """Returns whether it differs from another by more than numbers, such as a growing age."""
        return other is None or self._without_figures != other._without_figures  # noqa: SLF001

    @property
    def _without_figures(self) -> tuple[str, str]:
        return self.name, re.sub(r"-?\d+(\.\d+)?", "", self.reason)


def describe(command: Command, plan: Plan | None, now: float) -> Activity:
    """Returns the controller's activity at a command.

    Args:
        plan: the plan in force; None without one.
        now: time on the poses' clock [s].
    """
    if command.maneuver in (STOPPED, WAITING):
        return Activity(STOPPED, f"stands still: {command.reason}")
    if command.maneuver == HAND:
        return Activity(HAND, "is driven by hand")
    if command.reason:
        return Activity(TRACK, f"follows the plan slowly: {command.reason}")
    if command.maneuver in MANEUVER_REASONS:
        return Activity(MANEUVER, MANEUVER_REASONS[command.maneuver])
    touched = None if plan is None else _touched_now(plan.contacts, now)
    if touched is not None:
        return Activity(BOUNCE, f"bounces off the boundary at {touched[0]:.2f}, {touched[1]:.2f}")
    at_end = plan is not None and now > plan.times[-1]
    return Activity(TRACK, "holds the end of the plan" if at_end else "follows the plan")


def _touched_now(contacts: Contacts, now: float) -> np.ndarray | None:
    """Point (2,) [m] of the contact nearest to now, by time; None where none is within TIME_TOLERANCE."""
    if len(contacts.times) == 0:
        return None
    apart = np.abs(contacts.times - now)
    nearest = int(apart.argmin())
    return contacts.points[nearest] if apart[nearest] <= TIME_TOLERANCE else None
