"""Worlds made from a layout by mirroring and turning it at random."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from collplan_core.worlds.route import check_route
from collplan_core.worlds.shapes import World, WorldError

# only `random()` of the generator: its stream is the one thing no numpy version has changed
Draw = Callable[[float, float], float]


def draws_of(*seed: int) -> Draw:
    """A function of low and high that draws uniformly between them, from a stream of its own per seed."""
    bits = np.random.PCG64(seed[0] if len(seed) == 1 else seed)
    return partial(_uniform, np.random.Generator(bits))


def rounded(values: Sequence[Any] | np.ndarray) -> np.ndarray:
    """Coordinates [m] to a tenth of a millimetre."""
    # the last bits of cos and sin differ between machines, the world must not
    return np.round(np.array(values), 4)


def _uniform(generator: np.random.Generator, low: float, high: float) -> float:
    return low + (high - low) * float(generator.random())


SIDE = 2.4
"""Side of the walled square that every family stands in [m]."""
DISC_RADIUS = 0.10
"""Radius of the disc that every world but `posts` lets through [m], a centimetre more than the robot's."""
BODY_WIDTH = 0.18
"""Width of the robot [m]; passages are given by what they leave beside it."""


@dataclass(frozen=True, eq=False)
class Layout:
    """Rectangles (r, 4) x0, y0, x1, y1 of solid in the square, start (2,) and goal (2,) [m]."""

    solids: np.ndarray
    start: np.ndarray
    goal: np.ndarray


# None where what was drawn does not fit
LayOut = Callable[[Draw], Layout | None]


def seeded_world(family: str, lay_out: LayOut, seed: int) -> World:
    """The world FAMILY:SEED: the first layout drawn that fits and lets a disc of DISC_RADIUS from start to goal."""
    # the name is part of the seed, or the families would share their draws
    draw = draws_of(*family.encode(), seed)
    while True:
        layout = lay_out(draw)
        if layout is None:
            continue
        world = _placed(f"{family}:{seed}", layout, draw)
        try:
            check_route(world, world.start, world.goal, DISC_RADIUS)  # type: ignore[arg-type]
        except WorldError:
            continue
        return world


def _placed(name: str, layout: Layout, draw: Draw) -> World:
    """The layout, mirrored along x, along y or not, and its axes exchanged or not: each of the eight is as likely."""
    mirrored = np.array([draw(0.0, 1.0) < 0.5 for _ in range(2)])
    exchanged = draw(0.0, 1.0) < 0.5

    def turned(points: np.ndarray) -> np.ndarray:
        flipped = np.where(mirrored, SIDE - points, points)
        return rounded(flipped[..., ::-1] if exchanged else flipped)

    corners = layout.solids[:, [[0, 1], [2, 1], [2, 3], [0, 3]]]
    return World(
        name=name,
        polygons=tuple(turned(corners)),
        circles=np.zeros((0, 3)),
        bounds=(0.0, 0.0, SIDE, SIDE),
        start=turned(layout.start),
        goal=turned(layout.goal),
    )
