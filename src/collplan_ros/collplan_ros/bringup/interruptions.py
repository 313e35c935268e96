"""Counts the motions of a check that late commands or missing poses interrupted; such a motion is not used."""

from dataclasses import dataclass

from collplan_core.parameters import Limits

ENOUGH_MOTIONS = 6
"""Interrupted motions from which on their share counts."""
HOPELESS, MANY = 1 / 3, 0.1
"""Shares of interrupted motions beyond which the check ends, and beyond which it reports why it takes so long."""


@dataclass(frozen=True)
class Interruptions:
    """Counts of motions driven, of motions that were interrupted, and of commands that reached the robot too late."""

    motions: int = 0
    interrupted: int = 0
    refused: int = 0

    @property
    def are_hopeless(self) -> bool:
        """True where so many motions are interrupted that further ones are not worth driving."""
        return self._beyond(HOPELESS)

    @property
    def are_many(self) -> bool:
        """True where interruptions could be the reason for an uncertain result."""
        return self._beyond(MANY)

    def _beyond(self, share: float) -> bool:
        worst = max(self.interrupted, self.refused)
        return worst >= ENOUGH_MOTIONS and worst > share * self.motions


def is_interrupted(between_commands: float, between_poses: float, limits: Limits) -> bool:
    """Returns whether a motion with such longest gaps [s] may differ from the one commanded.

    The robot stops where a command is older than limits.command_age, and commands take some of that time to reach it.
    """
    return between_commands > 0.5 * limits.command_age or between_poses > 0.5 * limits.pose_age
