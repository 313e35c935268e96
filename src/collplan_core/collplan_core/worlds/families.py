"""The families of seeded worlds by name: the same seed gives the same world in every process."""

from collections.abc import Callable
from functools import partial

import numpy as np

from collplan_core.worlds.clutter import random_clutter, round_posts
from collplan_core.worlds.corridors import lay_out_l, lay_out_serpentine, lay_out_u, lay_out_z
from collplan_core.worlds.pillars import lay_out_pillars
from collplan_core.worlds.placement import BODY_WIDTH, SIDE, Draw, LayOut, Layout, rounded, seeded_world
from collplan_core.worlds.shapes import World

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


_LAYOUTS: dict[str, LayOut] = {
    "l": lay_out_l,
    "u": lay_out_u,
    "z": lay_out_z,
    "baffles": lay_out_baffles,
    "serpentine": lay_out_serpentine,
    "pillars": lay_out_pillars,
}

FAMILIES: dict[str, Callable[[int], World]] = {
    "random": random_clutter,
    "posts": round_posts,
    **{family: partial(seeded_world, family, lay_out) for family, lay_out in _LAYOUTS.items()},
}
