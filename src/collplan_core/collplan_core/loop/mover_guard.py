"""The controller's last check: a command is shortened where the robot could not brake any more for what moves.

Movers are those found in scans; with limits.emerging_speed also what may come out of where the newest scan shows
nothing. Some strategies also keep off the places that no scan has had in view: anything may stand there.
"""

import math
from dataclasses import replace

import numpy as np

from collplan_core.command import HAND, WAITING, Command
from collplan_core.control.follow import NARROWER
from collplan_core.loop.sensed_scans import PlacedScan
from collplan_core.movers.coverage import CELL
from collplan_core.movers.guard import ALLOWED, GROWTH, IN_HAND, MORE, REACH, body_of, largest_share
from collplan_core.movers.record import Movers
from collplan_core.movers.unseen import unseen_edges
from collplan_core.parameters import Settings
from collplan_core.plane import nearest_on_segment, rotate
from collplan_core.state import State
from collplan_core.strategies import is_careful

CREEP = 0.1
"""Own speed that is allowed towards what the robot does not see: right beside an edge it could not move on otherwise
[m/s]."""
OUT_OF_VIEW = "what it does not see"
"""What a robot keeps off that may stand for long before what no scan has shown."""
WAITS_WITHIN = 1.0
"""A robot that hardly moves and has a mover so near waits for it [m]."""


def kept_off(command: Command, state: State, movers: Movers, placed: PlacedScan | None, settings: Settings) -> Command:
    """The command, shortened so far that the robot can still brake for what moves; with the reason, where it is.

    A person sees the robot: by hand only what is faster than limits.blind_speed is checked. `state` is the robot when
    the command acts, its stamp the time then. Where nothing moves, and nothing may come out, the command is returned as
    it is. `placed` is the newest scan with its local map; None without one.
    """
    by_hand, limits = command.maneuver == HAND, settings.limits
    speed = float(np.hypot(*command.velocity))
    freely = max(limits.mover_speed, limits.blind_speed if by_hand else 0.0)
    expects = limits.emerging_speed > 0.0 or (is_careful(settings.planner.strategy) and not by_hand)
    reached = _reached(movers, placed if expects else None, state.stamp, settings, freely)
    if speed == 0.0 or len(reached) == 0:
        return command
    wanted = np.array(rotate(*command.velocity.tolist(), state.yaw))
    motion = np.concatenate([state.position, state.velocity])
    walls = np.zeros((0, 4)) if placed is None else placed.local_map.walls
    least = min(1.0, limits.blind_speed / speed) if by_hand else 0.0
    share, row = largest_share(reached, walls, body_of(settings), motion, wanted, least)
    sent = command if share == 1.0 else replace(command, velocity=share * command.velocity)
    near = _nearest(reached[: len(movers)], state, settings.robot.radius)
    if not by_hand and share * speed < CREEP and near < WAITS_WITHIN:
        return replace(sent, maneuver=WAITING, reason=f"waits for a mover {near:.1f} m away")
    if share == 1.0:
        return command
    away = _nearest(reached[row : row + 1], state, settings.robot.radius)
    if placed is None or reached[row, MORE] > 0.0:
        return replace(sent, reason=f"keeps off a mover {away:.1f} m away")
    hint = sight_hint(placed.local_map.unseen.blind, settings)
    return replace(sent, reason=": ".join(filter(None, (f"keeps off {OUT_OF_VIEW} {away:.1f} m away", hint))))


def sight_hint(blind: float, settings: Settings) -> str:
    """Says how much a LIDAR that leaves out `blind` [rad] sees; "" where that is nearly all, or it is turned."""
    if blind <= NARROWER or settings.controller.turns_to_look:
        return ""
    return f"the LIDAR sees {360.0 - math.degrees(blind):.0f} of 360 degrees, controller.turns_to_look is false"


def _reached(movers: Movers, placed: PlacedScan | None, now: float, settings: Settings, freely: float) -> np.ndarray:
    """(k, 10) what can be reached from `now` [s] on, for `movers.guard`; first the movers, allowed `freely` [m/s]."""
    moving, emerging = _or_slower(movers, now) if len(movers) else movers.rows, settings.limits.emerging_speed
    rows = np.empty((len(moving), 10))
    rows[:, :6] = moving[:, [0, 1, 0, 1, 2, 3]]
    rows[:, REACH], rows[:, GROWTH] = moving[:, 4] + settings.movers.clearance, moving[:, 5]
    rows[:, ALLOWED], rows[:, MORE] = freely, IN_HAND
    if placed is None:
        return rows
    shown, edges = placed.local_map, np.zeros((0, 4))
    if emerging > 0.0:
        edges = unseen_edges(shown.view, shown.view_from, shown.view_beams, shown.walls, placed.scan.range_max)
    edges = np.vstack([np.tile(shown.unseen.edges, 2), edges])
    unseen = np.zeros((len(edges), 10))
    unseen[:, :4], unseen[:, REACH] = edges, emerging * max(now - shown.stamp, 0.0)
    unseen[: len(shown.unseen.edges), REACH] += 0.5 * CELL
    unseen[:, GROWTH], unseen[:, ALLOWED] = emerging, max(freely, CREEP)
    return np.vstack([rows, unseen])


def _or_slower(movers: Movers, now: float) -> np.ndarray:
    """(m, 6) the movers' rows, and again those of discs that are alone, at half the speed."""
    # of a person of whom one leg alone moves so far, that leg is twice as fast as the person, and stops for the next
    rows, (_, of, legs) = movers.rows_at(now), np.unique(movers.numbers, return_inverse=True, return_counts=True)
    slower = rows[legs[of] == 1]
    slower[:, 2:4] *= 0.5
    return np.vstack([rows, slower])


def _nearest(reached: np.ndarray, state: State, radius: float) -> float:
    """Distance of the robot from the nearest of what can be reached [m]; inf where there is none."""
    to_axes = [state.position - nearest_on_segment(*row[:4], *state.position) for row in reached]
    gaps = [float(np.hypot(*to_axis)) - row[REACH] - radius for to_axis, row in zip(to_axes, reached, strict=True)]
    return max(0.0, min(gaps, default=math.inf))
