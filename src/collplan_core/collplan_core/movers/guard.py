"""The rule that the last command before the robot keeps: it does not drive into what moves.

A command is rolled out as the robot would go: held for a control period, then braked, with rebounds from the walls.
What moves grows meanwhile about its predicted place (S = K T + C of ISO 13855). Judged is the robot's own speed towards
it where the two can touch: a robot that stands or leaves may be reached, one that arrives may not. Pure functions.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.parameters import Settings
from collplan_core.plane import nearest_on_segment
from collplan_core.reflection import Ring, believed_ring, reflect
from collplan_core.velocity_law import VelocityLaw, velocity_after_step, velocity_law

STEP = 0.01
"""Step of a rollout [s]."""
LATENCY = 0.03
"""A command is in force for so much longer than a control period: age of the pose, half the velocity's window [s]."""
BRAKING_SHARE = 0.85
"""Share of max_acceleration that braking counts on. With all of it, braking ended in touches at 0.1 m/s."""
IN_HAND = 0.05
"""Distance more that a slower command needs; without it the robot stops and goes up to the last instant [m]."""
HALVINGS = 5
"""Tries for the largest share of a command that may be sent: the last one differs by 1/32 of it."""
SLOWEST = 0.03
"""Own speed that counts as none [m/s]: braking by a lag ends at rest in the limit alone, and the measured velocity of a
robot that stands is noise of this size."""
X0, Y0, X1, Y1, VX, VY, REACH, GROWTH, ALLOWED, MORE = range(10)
"""Columns of what can be reached: the ends of its axis [m], its velocity [m/s], how far it reaches from that axis [m],
how fast that grows [m/s], the robot's own speed towards it that is allowed at a touch [m/s], and the distance more that
a slower command needs [m]."""


class Body(NamedTuple):
    """The robot as the rule takes it."""

    radius: float  # [m]
    drives: VelocityLaw  # law by which it gains speed
    brakes: VelocityLaw  # law by which it loses it
    ring: Ring  # what a wall leaves of the velocity
    held: int  # steps for which a command is in force


def body_of(settings: Settings) -> Body:
    """The robot by the parameters."""
    law, held = velocity_law(settings.robot, STEP), 1.0 / settings.controller.rate + LATENCY
    braking = law._replace(max_acceleration=BRAKING_SHARE * law.max_acceleration)
    return Body(settings.robot.radius, law, braking, believed_ring(settings), math.ceil(held / STEP - 1e-6))


@njit
def largest_share(
    reached: np.ndarray, walls: np.ndarray, body: Body, motion: np.ndarray, command: np.ndarray, least: float
) -> tuple[float, int]:
    """The largest share of a command that may be sent, and the row of what forbids more of it; 1 and -1 without any.

    What the robot moves away from, and is commanded to, does not count: it may be slow to leave, but is never held. All
    of it, if it touches nothing in motion, or if it leads away from what it touches and braking would do no better;
    else a smaller share that does so with IN_HAND, found by halving; else `least`.

    Args:
        reached: (k, 10) what may be touched, at the time of the motion; columns as named above.
        walls: (w, 4) what the robot rebounds from [m].
        motion: (4,) x, y [m], vx, vy [m/s] when the command acts.
        command: (2,) [m/s], in the frame of the motion.
        least: share that is always allowed; 0 is braking.
    """
    near, solid = _within_reach(reached, walls, body, motion, command)
    near = near[is_approached(reached[near], motion, command)]
    if len(near) == 0 or least >= 1.0 or (command[0] == 0.0 and command[1] == 0.0):
        return 1.0, -1
    rows, walls = reached[near], walls[solid]
    found = own_speeds(rows, walls, body, motion, command, 0.0)
    excess = found - np.maximum(rows[:, ALLOWED], SLOWEST)
    if excess.max() <= 0.0:
        return 1.0, -1
    towards = _is_towards(rows, motion, command)
    braked = own_speeds(rows, walls, body, motion, least * command, 0.0)
    if _may_be_sent(rows, towards, found, braked, SLOWEST):
        return 1.0, -1
    low, high = least, 1.0
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        found = own_speeds(rows, walls, body, motion, share * command, IN_HAND)
        if _may_be_sent(rows, towards, found, braked, 0.0):
            low = share
        else:
            high = share
    return low, near[int(np.argmax(excess))]


@njit
def _may_be_sent(rows: np.ndarray, towards: np.ndarray, found: np.ndarray, braked: np.ndarray, still: float) -> bool:
    """Whether a command touches nothing in motion, or where it does leads away and is no worse than braking."""
    # A dodge ahead of a mover is no worse than braking either, and does not lead away. Speeds up to `still` are none
    # [m/s]: a slower command that was allowed them would creep up to the touch.
    return not ((found > np.maximum(rows[:, ALLOWED], still)) & (towards | (found > braked + 1e-9))).any()


@njit
def is_approached(rows: np.ndarray, motion: np.ndarray, command: np.ndarray) -> np.ndarray:
    """(k,) whether the robot moves towards the nearest point of each row, or is commanded to."""
    return _is_towards(rows, motion, command) | _is_towards(rows, motion, motion[2:])


@njit
def _is_towards(rows: np.ndarray, motion: np.ndarray, way: np.ndarray) -> np.ndarray:
    """(k,) whether a direction (2,) leads towards the nearest point of each row."""
    found = np.zeros(len(rows), np.bool_)
    for k in range(len(rows)):
        x, y = nearest_on_segment(rows[k, X0], rows[k, Y0], rows[k, X1], rows[k, Y1], motion[0], motion[1])
        found[k] = (x - motion[0]) * way[0] + (y - motion[1]) * way[1] > 0.0
    return found


@njit
def _within_reach(
    reached: np.ndarray, walls: np.ndarray, body: Body, motion: np.ndarray, command: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the rows and of the walls that a command followed by braking could come to."""
    top = max(math.hypot(motion[2], motion[3]), math.hypot(command[0], command[1]))
    duration = body.held * STEP + top / body.brakes.max_acceleration + 5.0 * body.brakes.lag
    way = body.radius + top * (body.held * STEP + 0.5 * top / body.brakes.max_acceleration + body.brakes.lag)
    near = np.zeros(len(reached), np.bool_)
    for k in range(len(reached)):
        x0, y0, x1, y1, vx, vy, reach, growth, _, more = reached[k]
        x, y = nearest_on_segment(x0, y0, x1, y1, motion[0], motion[1])
        most = way + reach + more + (growth + math.hypot(vx, vy)) * duration
        near[k] = math.hypot(x - motion[0], y - motion[1]) < most
    solid = np.zeros(len(walls), np.bool_)
    for k in range(len(walls)):
        x, y = nearest_on_segment(walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3], motion[0], motion[1])
        solid[k] = math.hypot(x - motion[0], y - motion[1]) < way
    return np.flatnonzero(near), np.flatnonzero(solid)


@njit
def own_speeds(
    reached: np.ndarray, walls: np.ndarray, body: Body, motion: np.ndarray, command: np.ndarray, more: float
) -> np.ndarray:
    """(k,) the robot's largest own speed towards each row where they can touch, under a command and braking [m/s].

    Speeds below what is allowed towards all are not followed to their end: braking approaches rest without reaching it.
    The first five arguments are as for `largest_share`; `more` is the distance more that counts as a touch, at most the
    column MORE [m].
    """
    x, y, vx, vy = motion
    found, met = np.zeros(len(reached)), np.full(len(reached), math.inf)
    law = body.drives if math.hypot(command[0], command[1]) > math.hypot(vx, vy) else body.brakes
    slowest, step = max(SLOWEST, reached[:, ALLOWED].min()), 0
    while step < body.held or math.hypot(vx, vy) > slowest:
        if step < body.held:
            wx, wy = velocity_after_step(law, vx, vy, command[0], command[1])
        else:
            wx, wy = velocity_after_step(body.brakes, vx, vy, 0.0, 0.0)
        x, y, step = x + 0.5 * (vx + wx) * STEP, y + 0.5 * (vy + wy) * STEP, step + 1
        vx, vy = _rebounded(walls, body, x, y, wx, wy)
        for k in range(len(reached)):
            speed, touches = _towards(reached[k], step * STEP, met[k], (x, y, vx, vy), body.radius, more)
            found[k] = max(found[k], speed)
            if touches and met[k] == math.inf:
                met[k] = step * STEP
    return found


@njit
def _rebounded(walls: np.ndarray, body: Body, x: float, y: float, vx: float, vy: float) -> tuple[float, float]:
    """Velocity after the walls that a disc at (x, y) drives into [m/s]."""
    for k in range(len(walls)):
        cx, cy = nearest_on_segment(walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3], x, y)
        nx, ny = x - cx, y - cy
        if vx * nx + vy * ny < 0.0 and nx * nx + ny * ny < body.radius * body.radius:
            far = math.hypot(nx, ny)
            vx, vy, _ = reflect(vx, vy, 0.0, nx / far, ny / far, body.ring)
    return vx, vy


@njit
def _towards(
    row: np.ndarray, t: float, met: float, motion: tuple[float, float, float, float], radius: float, more: float
) -> tuple[float, bool]:
    """Own speed towards what can be touched at time t, 0 elsewhere [m/s]; whether it touches on its predicted way."""
    # What has met the robot, at the time `met`, goes no farther: it does not come out in front of one that it pushes.
    x, y, vx, vy = motion
    s = min(t, met)
    ax, ay = row[X0] + s * row[VX] - x, row[Y0] + s * row[VY] - y
    bx, by = ax + row[X1] - row[X0], ay + row[Y1] - row[Y0]
    cx, cy = nearest_on_segment(ax, ay, bx, by, 0.0, 0.0)
    near2, bodies = cx * cx + cy * cy, radius + row[REACH]
    most = bodies + min(more, row[MORE]) + row[GROWTH] * t
    if near2 >= most * most:
        return 0.0, False
    # the part of the axis that is near enough, to both sides of the nearest point
    dx, dy = bx - ax, by - ay
    length2 = dx * dx + dy * dy
    speed, touches = _along(vx, vy, cx, cy), near2 < bodies * bodies
    if length2 < 1e-12:
        return speed, touches
    foot = -(ax * dx + ay * dy) / length2
    off2 = (ax + foot * dx) ** 2 + (ay + foot * dy) ** 2
    half = math.sqrt(max(0.0, most * most - off2) / length2)
    low, high = max(0.0, foot - half), min(1.0, foot + half)
    px, py, qx, qy = ax + low * dx, ay + low * dy, ax + high * dx, ay + high * dy
    p_side, q_side = abs(vx * py - vy * px), abs(vx * qy - vy * qx)
    if (vx * py - vy * px) * (vx * qy - vy * qx) < 0.0 and (
        vx * (q_side * px + p_side * qx) + vy * (q_side * py + p_side * qy) > 0.0
    ):
        return math.hypot(vx, vy), touches
    return max(speed, _along(vx, vy, px, py), _along(vx, vy, qx, qy)), touches


@njit
def _along(vx: float, vy: float, x: float, y: float) -> float:
    """Speed towards (x, y) from the origin; 0 away from it, and at it, where there is no direction."""
    far = math.hypot(x, y)
    return max(0.0, (vx * x + vy * y) / far) if far > 1e-9 else 0.0
