"""When a touch of a mover could not have been avoided by stopping: a rule of geometry, written before the first run.

A program is asked to stop before what it can know. It can know a mover's motion once it has had the mover in view,
moving as it does at the touch, for REACTION. The rule takes the last moment before the touch at which one of these
held:

- less than SEEN of the mover's disc was in the line of sight from the robot's centre: walls or other movers hid it;
- its velocity differed by more than CHANGE from that at the touch: it turned, stopped or set out;
- any mover touched the robot: what the robot then has is the velocity of a hit.

Without such a moment a stop could have saved the run. Else the rule lets the robot brake from its true state REACTION
after that moment, straight on, by its own law (a_max and lag), with the mover on its true way, and beyond the touch at
its last velocity. What touches then above STILL, or touched before the reaction was over, appeared too close.

REACTION is a scan until the mover is in one (0.05 s), 0.05 m of its way until its motion shows (0.1 s at 0.5 m/s),
another scan and a control period (0.05 s each). The drive moves a robot at rest by up to 0.07 m/s, so STILL is above
that. Of the program nothing counts but where it drove and how fast. So the rule excuses one that drives fast past blind
corners, and does not excuse one that could only have dodged earlier; `touched` counts all.
"""

from dataclasses import replace

import numpy as np

from collplan_core.parameters import Robot
from collplan_core.worlds import World
from collplan_core.worlds.raycast import cast_beams

REACTION = 0.25
"""[s]"""
SEEN = 1.0 / 3.0
"""Share of its disc."""
CHANGE = 0.2
"""[m/s]"""
STILL = 0.10
"""The robot's own speed towards a mover up to which a touch is no touch in motion [m/s]."""
RAYS = np.linspace(-0.9, 0.9, 9)
"""Places across a disc that are looked for, in radii."""
LONGEST, STEP = 2.0, 0.005
"""Duration of a braking that is computed, and its step [s]."""


def share_in_view(world: World, places: np.ndarray, movers: np.ndarray, number: int) -> np.ndarray:
    """(n,) share of a mover's disc in view from places (n, 2) [m], with all movers (n, k, 5) where they then are."""
    discs = movers[:, :, [0, 1, 4]]
    towards = discs[:, number, :2] - places
    across = np.column_stack([-towards[:, 1], towards[:, 0]]) / np.maximum(np.hypot(*towards.T), 1e-9)[:, None]
    points = towards[:, None] + discs[:, number, 2, None, None] * RAYS[None, :, None] * across[:, None]
    rays = points.reshape(-1, 2)
    others = np.repeat(np.delete(discs, number, axis=1), len(RAYS), axis=0)
    walls = replace(world, movers=())
    seen = cast_beams(walls, np.repeat(places, len(RAYS), axis=0), np.arctan2(rays[:, 1], rays[:, 0]), others)
    return (seen >= np.hypot(*rays.T)).reshape(-1, len(RAYS)).mean(axis=1)


def speed_left(
    trajectory: np.ndarray,
    mover: np.ndarray,
    in_view: np.ndarray,
    time: float,
    touched_at: float,
    robot: Robot,
    touched_before: float = -np.inf,
) -> float:
    """The robot's own speed towards a mover at the touch that the best stop leaves, 0 if it does not touch [m/s].

    Args:
        trajectory: (m, 5) t, x, y, vx, vy of the robot.
        mover: (m, 5) x, y, vx, vy, radius of the mover at these times.
        in_view: (m,) share of it in view.
        time, touched_before: of the touch, and of the one before, of any mover [s].
        touched_at: the robot's own speed towards the mover then [m/s].
    """
    times = trajectory[:, 0]
    last = int(np.searchsorted(times, time - 1e-6)) - 1
    if last < 0:
        return 0.0  # before its first command
    differs = np.hypot(*(mover[: last + 1, 2:4] - mover[last, 2:4]).T) > CHANGE
    unknown = np.flatnonzero(differs | (in_view[: last + 1] < SEEN))
    reacts = max(times[unknown[-1]] if len(unknown) else -np.inf, touched_before) + REACTION
    if reacts < times[0]:
        return 0.0
    if reacts >= time:
        return touched_at
    x, y, vx, vy = (float(np.interp(reacts, times, column)) for column in trajectory[:, 1:].T)
    left, reach = 0.0, robot.radius + float(mover[0, 4])
    for now in np.arange(reacts, reacts + LONGEST, STEP):
        apart = _place(times, mover, last, now) - (x, y)
        distance = float(np.hypot(*apart))
        if distance <= reach:
            left = max(left, float((vx, vy) @ apart) / max(distance, 1e-9))
        speed = float(np.hypot(vx, vy))
        lost = min(speed / robot.velocity_lag, robot.max_acceleration) * STEP if robot.velocity_lag > 0.0 else speed
        share = max(0.0, 1.0 - lost / max(speed, 1e-9))
        x, y, vx, vy = x + vx * STEP, y + vy * STEP, share * vx, share * vy
    return left


def _place(times: np.ndarray, mover: np.ndarray, last: int, now: float) -> np.ndarray:
    """The mover's true place, and from its last sample before the touch on that at its velocity then."""
    known = min(now, float(times[last]))
    place = np.array([np.interp(known, times[: last + 1], column) for column in mover[: last + 1, :2].T])
    return place + (now - known) * mover[last, 2:4]
