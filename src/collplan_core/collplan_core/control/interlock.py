"""Interlock: once held, a robot moves again only after a person gives a new goal or resumes.

Both ends of the graph use it, each for its own faults: the controller for poses, scans and plans, the robot for
commands, the line and the emergency stop.
"""

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
