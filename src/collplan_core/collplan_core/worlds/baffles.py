"""The family `baffles`: a room with walls across it that leave gaps on alternating sides."""

import numpy as np

from collplan_core.worlds.draws import Draw, rounded
from collplan_core.worlds.placement import BODY_WIDTH, SIDE, Layout

N_WALLS = 3
THICKNESS = (0.05, 0.15)
# beside the robot [m]
SPARE = (0.10, 0.40)
# of a wall's middle from where equal chambers would have it [m]
SHIFT = 0.08
# start and goal: from the end of the room, and from its sides [m]
INSET = (0.14, 0.24)
FROM_SIDE = 0.3


def lay_out_baffles(draw: Draw) -> Layout:
    """Start and goal at opposite ends, each anywhere across the room."""
    walls = [_wall(draw, i) for i in range(N_WALLS)]
    start = [draw(*INSET), draw(FROM_SIDE, SIDE - FROM_SIDE)]
    goal = [SIDE - draw(*INSET), draw(FROM_SIDE, SIDE - FROM_SIDE)]
    return Layout(rounded(walls), np.array(start), np.array(goal))


def _wall(draw: Draw, i: int) -> list[float]:
    """Wall i, x0, y0, x1, y1 [m], with a gap between its end and the side of the room."""
    half = draw(*THICKNESS) / 2
    x = SIDE * (i + 1) / (N_WALLS + 1) + draw(-SHIFT, SHIFT)
    gap = BODY_WIDTH + draw(*SPARE)
    low, high = (gap, SIDE) if i % 2 else (0.0, SIDE - gap)
    return [x - half, low, x + half, high]
