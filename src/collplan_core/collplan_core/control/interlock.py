"""Interlock: once held, a robot moves again only after a person gives a new goal or resumes.

Both ends of the graph use it, each for its own faults: the controller for poses, scans and plans, the robot for
commands, the line and the emergency stop.
"""

import math
from dataclasses import dataclass, replace

KNOWN_GOALS = 100
"""Number of goals that are remembered, the newest ones."""
LONGEST_FAULT = 1.0
"""A fault that lasts longer holds the robot [s]; after a shorter one it goes on."""
REMEDY = "give a new goal, or call resume"
"""Action by which a person releases the robot, in words."""


@dataclass(frozen=True)
class Interlock:
    """Held or free. No command, zero or not, changes it, nor does time."""

    reason: str = ""  # reason why the robot is held; empty where it may move
    goals: tuple[bytes, ...] = ()  # identities of the goals received, the newest last, whatever their status

    def held(self, reason: str) -> "Interlock":
        """Returns the interlock, held from now on."""
        return replace(self, reason=reason)

    def resumed(self) -> "Interlock":
        """Returns the interlock, free from now on."""
        return replace(self, reason="")

    def is_new(self, goal: bytes, active: bool) -> bool:
        """Returns whether a person has given this goal now: it is active and was never received before.

        The first goal received does not count: it may have been given before a restart.
        """
        return active and bool(self.goals) and goal not in self.goals

    def after_goal(self, goal: bytes) -> "Interlock":
        """Returns the interlock with a goal noted by its identity; held or free as before."""
        others = [known for known in self.goals if known != goal]
        return replace(self, goals=(*others, goal)[-KNOWN_GOALS:])


@dataclass(frozen=True)
class Hold:
    """The controller's interlock, and what is to hold the robot where it lasts; times on the local clock [s]."""

    interlock: Interlock = Interlock()
    patience: float = LONGEST_FAULT  # time for which there may be a reason to stand
    fault_since: float = math.inf  # time since which there is one; inf without
    lost_since: float = math.inf  # the same of what was there before
    mistrusted: str = ""  # verdict for which motion is mistrusted until a person resumes; empty without
    kidnapping_is_known: bool = False  # whether a person has let the robot go on while its poses were refused

    def held(self, reason: str) -> "Hold":
        """Returns the same, held from now on."""
        return replace(self, interlock=self.interlock.held(reason))

    def resumed(self, patience: float, kidnapping_is_known: bool) -> "Hold":
        """Returns the same, free from now on; inputs and a plan must be there within `patience` [s]."""
        return Hold(self.interlock.resumed(), patience, kidnapping_is_known=kidnapping_is_known)

    def after(self, reason: str, lost: str, local: float) -> "Hold":
        """Returns the same after a period with a reason to stand, and one by what was there; "" without.

        It is held where the first has lasted for `patience`, or the second for LONGEST_FAULT.
        """
        since = min(self.fault_since, local) if reason else math.inf
        lost_since = min(self.lost_since, local) if lost else math.inf
        hold = replace(self, fault_since=since, lost_since=lost_since)
        if not reason:
            return replace(hold, patience=LONGEST_FAULT)
        lasts = local - since > self.patience or local - lost_since > LONGEST_FAULT
        return hold.held(reason) if lasts else hold
