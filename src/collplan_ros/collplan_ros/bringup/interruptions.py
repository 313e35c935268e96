"""Counts the motions of a check that late commands or missing poses interrupted; such a motion is not used."""

from dataclasses import dataclass, replace

from collplan_core.parameters import Limits

ENOUGH_MOTIONS = 6
"""Interrupted motions from which on their share counts."""
HOPELESS, MANY = 1 / 3, 0.1
"""Shares of interrupted motions beyond which the check ends, and beyond which it says why it takes so long."""


@dataclass(frozen=True)
class Interruptions:
    """The motions so far.

    Attributes:
        motions: how many were driven; interrupted: how many of them showed nothing.
        between_commands: longest time between two commands in one of these [s].
        between_poses: longest time between two poses in one of these, by stamps or by receipt [s].
        refused: commands that the robot found too late.
    """

    motions: int = 0
    interrupted: int = 0
    between_commands: float = 0.0
    between_poses: float = 0.0
    refused: int = 0

    def after(self, is_interrupted: bool, between_commands: float, between_poses: float) -> "Interruptions":
        """These after one more motion, with its figures [s]."""
        if not is_interrupted:
            return replace(self, motions=self.motions + 1)
        longest = max(self.between_commands, between_commands), max(self.between_poses, between_poses)
        return Interruptions(self.motions + 1, self.interrupted + 1, *longest, self.refused)

    @property
    def are_hopeless(self) -> bool:
        """Whether so many motions are interrupted that no more are worth it."""
        return self._beyond(HOPELESS)

    @property
    def are_many(self) -> bool:
        """Whether they could be why a result is uncertain."""
        return self._beyond(MANY)

    def _beyond(self, share: float) -> bool:
        worst = max(self.interrupted, self.refused)
        return worst >= ENOUGH_MOTIONS and worst > share * self.motions


def is_interrupted(between_commands: float, between_stamps: float, limits: Limits) -> bool:
    """Whether a motion with such longest gaps [s] may have been another one than was commanded.

    The robot stops where a command is older than limits.command_age, and commands take some of that time to reach it.
    """
    return between_commands > 0.5 * limits.command_age or between_stamps > 0.5 * limits.pose_age
