"""The controller's last check: a command is shortened where the robot could not brake any more for what moves.

Movers are those found in scans; with limits.emerging_speed also what may come out of where the newest scan shows
nothing.
"""

from dataclasses import dataclass, replace

import numpy as np

from collplan_core.command import HAND, Command, stopped
from collplan_core.loop.sensed_scans import PlacedScan
from collplan_core.movers.guard import IN_HAND, away_from, body_of, largest_share
from collplan_core.movers.record import Movers
from collplan_core.movers.unseen import unseen_edges
from collplan_core.parameters import Settings
from collplan_core.plane import nearest_on_segment, rotate
from collplan_core.state import State

CREEP = 0.1
"""Own speed that is allowed towards what the robot does not see: right beside an edge it could not move on otherwise
[m/s]."""
OWN_SURFACE = 0.1
"""Walls in a scan so near to a mover are its own surface, from which nothing rebounds once it has moved [m]."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What a command is checked against.

    Attributes:
        movers: what moves.
        placed: newest scan with its local map; None without one.
    """

    movers: Movers
    placed: PlacedScan | None

    def reached(self, now: float, settings: Settings, by_hand: bool) -> np.ndarray:
        """(k, 10) what can be reached from `now` [s] on, for `movers.guard`; first the movers."""
        limits = settings.limits
        freely = max(limits.mover_speed, limits.blind_speed if by_hand else 0.0)
        moving = self.movers.rows_at(now)
        rows = np.empty((len(moving), 10))
        rows[:, :6], rows[:, 4:6] = moving[:, [0, 1, 0, 1, 2, 3]], moving[:, 2:4]
        rows[:, 6], rows[:, 7] = moving[:, 4] + settings.movers.clearance, moving[:, 5]
        rows[:, 8], rows[:, 9] = freely, IN_HAND
        if limits.emerging_speed == 0.0 or self.placed is None:
            return rows
        shown = self.placed.local_map
        edges = unseen_edges(shown.view, shown.view_from, shown.view_beams, shown.walls, self.placed.scan.range_max)
        unseen = np.zeros((len(edges), 10))
        unseen[:, :4] = edges
        unseen[:, 6] = limits.emerging_speed * max(now - shown.stamp, 0.0)
        unseen[:, 7], unseen[:, 8] = limits.emerging_speed, max(freely, CREEP)
        return np.vstack([rows, unseen])

    def walls(self) -> np.ndarray:
        """(w, 4) walls of the newest scan without the surfaces of movers [m]."""
        if self.placed is None:
            return np.zeros((0, 4))
        shown = self.placed.local_map
        discs = self.movers.rows_at(shown.stamp)[:, [0, 1, 4]]
        discs[:, 2] += OWN_SURFACE
        return away_from(shown.walls, discs)


def kept_off(command: Command, state: State, around: Surroundings, settings: Settings) -> Command:
    """The command, shortened so far that the robot can still brake for what moves; with the reason, where it is.

    A person sees the robot: by hand only what is faster than limits.blind_speed is checked.

    Args:
        state: the robot when the command acts, its stamp the time then.
        around: what is there; where that is nothing, the command is returned as it is.
    """
    by_hand = command.maneuver == HAND
    speed = float(np.hypot(*command.velocity))
    if speed == 0.0:
        return command
    reached = around.reached(state.stamp, settings, by_hand)
    if len(reached) == 0:
        return command
    wanted = np.array(rotate(*command.velocity.tolist(), state.yaw))
    motion = np.concatenate([state.position, state.velocity])
    least = min(1.0, settings.limits.blind_speed / speed) if by_hand else 0.0
    share, row = largest_share(reached, around.walls(), body_of(settings), motion, wanted, least)
    if share == 1.0:
        return command
    x, y = nearest_on_segment(*reached[row, :4].tolist(), *state.position.tolist())
    away = float(np.hypot(*(state.position - (x, y)))) - settings.robot.radius
    if row < len(around.movers):
        reason = f"keeps off a mover {max(0.0, away - around.movers.radii[row]):.1f} m away"
    else:
        reason = f"keeps off what it does not see {max(0.0, away):.1f} m away"
    if share == 0.0 and not by_hand:
        return stopped(reason)
    return replace(command, velocity=share * command.velocity, reason=reason)
