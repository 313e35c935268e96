"""The legs of a person who walks: one stands while the other swings past it at twice the speed of walking.

With the stride S [m] of two steps and u = walked / S, leg 0 is at S (floor(u) + max(0, 2 frac(u) - 1) + 1/4) along the
line that the person walks on, and leg 1 half a cycle later: their mean is the person's own place.
"""

from typing import NamedTuple

import numpy as np

from collplan_core.worlds.movers import DISC, HIP, Mover, place_at, since_set_out

STRIDE, AT = 1.4, 1.3
"""Length of two steps [m] at a speed of walking [m/s]; it grows with the root of the speed."""
TURN = 0.3
"""Way before and after a way point over which a person turns [m]."""


class Gait(NamedTuple):
    """How a mover goes along its line."""

    mover: Mover  # who goes
    walked: np.ndarray  # (n,) way walked at the times of the mover's schedule [m]
    turns: np.ndarray  # (k,) ways between which the heading changes evenly [m]
    headings: np.ndarray  # (k,) headings there, not wrapped [rad]
    stride: float  # length of two steps [m]


def gait_of(mover: Mover) -> Gait:
    """The gait of a mover; the heading of one who only stands is 0."""
    places = mover.schedule[1]
    lengths = np.hypot(*np.diff(places, axis=0).T)
    walked = np.concatenate([[0.0], np.cumsum(lengths)])
    legs, length = np.diff(places, axis=0)[lengths > 0.0], float(walked[-1])
    if len(legs) == 0:
        return Gait(mover, walked, np.zeros(1), np.zeros(1), STRIDE)
    ends = walked[1:][lengths > 0.0]
    headings = np.unwrap(np.arctan2(*np.vstack([legs, legs[:1]]).T[::-1]))
    room = np.minimum(TURN, 0.5 * lengths[lengths > 0.0])
    turns = [0.0, room[0]]
    between = [headings[0] - 0.5 * (headings[-1] - headings[-2]) if mover.to_and_fro else headings[0], headings[0]]
    for k in range(len(legs) - 1):
        turn = min(room[k], room[k + 1])
        turns += [ends[k] - turn, ends[k] + turn]
        between += headings[k : k + 2].tolist()
    turns += [length - min(room[-1], room[0]), length]
    between += [headings[-2], 0.5 * (headings[-2] + headings[-1]) if mover.to_and_fro else headings[-2]]
    stride = STRIDE * float(np.sqrt(mover.speed / AT))
    if mover.to_and_fro:  # whole strides, so that it sets out again on the same leg
        stride = length / max(1, round(length / stride))
    return Gait(mover, walked, np.array(turns), np.array(between), stride)


def discs_at(gait: Gait, time: float) -> list[tuple[float, float]]:
    """Places of the discs of a mover that nothing hinders, of a person those of its two legs [m]."""
    mover = gait.mover
    if mover.kind == DISC:
        return [place_at(mover, time)]
    walked = float(np.interp(since_set_out(mover, time), mover.schedule[0], gait.walked))
    return [_leg(gait, walked, side) for side in (0, 1)]


def _leg(gait: Gait, walked: float, side: int) -> tuple[float, float]:
    """Place of leg 0, at the left, or 1 [m]."""
    places, length = gait.mover.schedule[1], float(gait.walked[-1])
    whole, part = divmod(walked / gait.stride + 0.5 * side, 1.0)
    along = gait.stride * (whole + max(0.0, 2.0 * part - 1.0) + 0.25 - 0.5 * side)
    if gait.mover.to_and_fro and length > 0.0:
        along %= length
    x, y = (float(np.interp(along, gait.walked, places[:, k])) for k in (0, 1))
    heading, aside = float(np.interp(along, gait.turns, gait.headings)), HIP * (1 - 2 * side)
    return x - aside * float(np.sin(heading)), y + aside * float(np.cos(heading))
