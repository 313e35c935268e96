"""The families of seeded worlds by name: the same seed gives the same world in every process."""

from collections.abc import Callable
from functools import partial

from collplan_core.worlds.baffles import lay_out_baffles
from collplan_core.worlds.clutter import random_clutter, round_posts
from collplan_core.worlds.corridors import lay_out_l, lay_out_serpentine, lay_out_u, lay_out_z
from collplan_core.worlds.pillars import lay_out_pillars
from collplan_core.worlds.placement import LayOut, seeded_world
from collplan_core.worlds.shapes import World

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
