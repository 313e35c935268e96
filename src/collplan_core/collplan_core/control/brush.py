"""Brushed is not broken: a robot that a contact has moved a little goes on by itself, slowly at first.

What looks like a fault of the base may be somebody who brushed the robot. The hold is put off: the robot stands, and
goes on after RESTS at rest if all that moved it was small, and its poses unbroken. More than that, or twice within
AGAIN, holds it: a base that does not obey goes on moving, or does so again.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from collplan_core.control.motion_monitor import MotionRecord
from collplan_core.control.runaway import MOVES
from collplan_core.parameters import Settings
from collplan_core.velocity_law import rolled, velocity_law

LASTS, MOVED, TURNED = 1.0, 0.10, math.radians(10.0)
"""Time within which a contact moves the robot [s], and most by which, beside its commands [m], and turns it [rad]."""
RESTS, AGAIN = 1.0, 10.0
"""Time at rest after which the robot goes on, and time within which a second brush holds it [s]."""
SLOWLY = 0.5
"""Distance from where it went on within which it drives at limits.blind_speed at most [m]."""
ENDS = 4.0
"""A robot that has not rested by then goes on being moved [s]: LASTS, RESTS, and the time to brake from 3 m/s."""


@dataclass(frozen=True)
class Brush:
    """A hold that is put off, and what moved the robot since; times on the local clock."""

    why: str = ""  # reason for the hold that is put off; empty where none is
    held: str = ""  # the same, once the robot is to be held for it
    begun: float = -math.inf  # time of the newest such reason [s]
    moving: float = -math.inf  # newest time at which the robot moved since [s]
    led: tuple[float, ...] = ()
    """Stamp [s], x, y [m], vx, vy [m/s], yaw [rad] to which its commands alone would have led."""
    went_on: tuple[float, float] | None = None  # where it went on by itself [m]; None before it ever did

    def is_fresh(self, x: float, y: float) -> bool:
        """Returns whether the robot is so near to where it went on [m] that it is to drive slowly."""
        return self.went_on is not None and math.dist(self.went_on, (x, y)) < SLOWLY


def judge_brush(brush: Brush, why: str, record: MotionRecord, now: float, settings: Settings) -> Brush:
    """The brush at `now` [s]; `why` is a reason to hold the robot now that a contact explains, empty without one."""
    rows = record.motion
    if not brush.why:
        if not why:
            left = brush.went_on is not None and len(rows) > 0 and not brush.is_fresh(*rows[-1, 4:6].tolist())
            return replace(brush, went_on=None) if left else brush
        rows = rows[rows[:, 0] >= now - LASTS - settings.limits.pose_age]
        is_final = settings.limits.blind_speed == 0.0 or now - brush.begun < AGAIN
        if is_final or len(rows) == 0 or rows[0, 0] > now - LASTS:
            return replace(brush, held=why, begun=now)
        led = rows[0, [1, 4, 5, 2, 3, 6]].tolist()
        brush = Brush(why, begun=now, moving=now, led=tuple(led))
    rows = rows[rows[:, 1] > brush.led[0]]
    led, small = _followed(brush.led, rows, record, settings)
    is_heard = len(record.motion) > 0 and now - record.motion[-1, 0] <= settings.limits.pose_age
    if not (small and is_heard) or now - brush.begun > ENDS:
        return replace(brush, why="", held=brush.why)
    if math.hypot(*record.motion[-1, 2:4].tolist()) > MOVES:
        return replace(brush, led=led, moving=now)
    if now - brush.moving < RESTS:
        return replace(brush, led=led)
    x, y = record.motion[-1, 4:6].tolist()
    return replace(brush, why="", led=led, went_on=(x, y))


def _followed(
    led: tuple[float, ...], rows: np.ndarray, record: MotionRecord, settings: Settings
) -> tuple[tuple[float, ...], bool]:
    """State to which the commands lead, and whether the poses stay near it, without gaps and in time."""
    limits, wanted = settings.limits, np.vstack([np.zeros((1, 2)), record.commands[:, 1:]])
    delay = settings.robot.motion_delay if math.isnan(record.delay) else record.delay
    received, stamps, yaw = rows[:, 0], np.append(led[0], rows[:, 1]), led[5]
    newest, spans = record.commands[:, 0].searchsorted(received - delay, side="right"), np.diff(stamps)
    way = rolled(velocity_law(settings.robot), np.array(led[1:5]), wanted[newest], spans)
    moved = np.hypot(*(way[1:, :2] - rows[:, 4:6]).T)
    turned = abs((rows[:, 6] - yaw + math.pi) % math.tau - math.pi)
    in_time = (spans <= limits.pose_age) & (received - rows[:, 1] - record.quickest <= limits.motion_delay)
    small = bool(((moved <= MOVED) & (turned <= TURNED) & in_time).all())
    return (float(stamps[-1]), *way[-1].tolist(), yaw), small
