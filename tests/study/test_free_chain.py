"""The chain of boxes and corners is the free space of the disc's centre, no more and no less, and leads through it."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.worlds import World, WorldError, load_world
from collplan_core.worlds.route import QUARTER_SEGMENTS, free_space
from collplan_study.optimum.free_chain import Region, free_chain
from collplan_study.question.held_out import OPTIMUM_FAMILIES

ARC = 2e-5
"""shapely's arcs are off by less than this [m]."""


def area_of(region: Region, radius: float) -> shapely.Geometry:
    rectangle = shapely.box(*region.low, *region.high)
    if region.vertex is None:
        return rectangle
    return rectangle.difference(shapely.Point(region.vertex).buffer(radius, quad_segs=QUARTER_SEGMENTS))


def joined(area: shapely.Geometry, *points: np.ndarray) -> bool:
    """Whether one piece of an area holds all points."""
    return any(all(piece.covers(shapely.Point(p)) for p in points) for piece in getattr(area, "geoms", [area]))


def world_of(*solids: list[float], start=(0.2, 0.2), goal=(1.8, 1.8)) -> World:
    """A room of 2 m x 2 m with solid rectangles x0, y0, x1, y1 in it."""
    corners = [np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) for x0, y0, x1, y1 in solids]
    return World("room", tuple(corners), np.zeros((0, 3)), (0, 0, 2, 2), start=np.array(start), goal=np.array(goal))


BLOCK = [0.0, 0.4, 1.6, 2.0]
"""In that room it leaves an l, 0.4 m wide."""


@given(
    family=st.sampled_from(OPTIMUM_FAMILIES),
    seed=st.integers(0, 2**40),
    radius=st.floats(0.02, 0.12),
)
@settings(derandomize=True, deadline=None, max_examples=40)
def test_the_chain_is_the_free_space_and_each_box_is_on_the_way(family, seed, radius):
    world = load_world(f"{family}:{seed}")
    chain = free_chain(world, radius)
    free = free_space(world, radius)
    areas = [area_of(region, radius) for region in chain.regions]
    whole = shapely.union_all(areas)
    assert free.buffer(ARC).covers(whole)
    assert whole.buffer(ARC).covers(free)

    assert [region.vertex is None for region in chain.regions] == [i % 2 == 0 for i in range(len(areas))]
    assert areas[0].covers(shapely.Point(chain.start))
    assert areas[-1].covers(shapely.Point(chain.goal))
    assert min(a.intersection(b).area for a, b in pairwise(areas)) > 0.0
    assert joined(free, chain.start, chain.goal)
    # the lower bound rests on this
    assert not any(joined(free.difference(box.buffer(1e-6)), chain.start, chain.goal) for box in areas[2:-1:2])


def test_each_leg_is_a_box_and_an_empty_room_is_one():
    for family, boxes in [("l", 2), ("u", 3), ("z", 3), ("serpentine", 7), ("baffles", 7)]:
        assert len(free_chain(load_world(f"{family}:0"), 0.09).regions) == 2 * boxes - 1, family
    (box,) = free_chain(world_of(), 0.1).regions
    assert box.vertex is None
    assert [*box.low, *box.high] == pytest.approx([0.1, 0.1, 1.9, 1.9])


def test_an_l_by_hand():
    one, corner, other = free_chain(world_of(BLOCK), 0.1).regions
    expected = [
        (one, (0.1, 0.1), (1.9, 0.3), None),
        (corner, (1.6, 0.1), (1.9, 0.4), (1.6, 0.4)),
        (other, (1.7, 0.1), (1.9, 1.9), None),
    ]
    for region, low, high, vertex in expected:
        assert region.low == pytest.approx(low)
        assert region.high == pytest.approx(high)
        assert region.vertex == (None if vertex is None else pytest.approx(vertex))


REFUSED = {
    "circles and slopes": (load_world("random:3"), 0.09),
    "pillars": (load_world("pillars:0"), 0.09),
    "too narrow": (world_of(BLOCK), 0.21),
    "no goal": (replace(world_of(BLOCK), goal=None), 0.1),
    "no walls": (replace(world_of(BLOCK), walled=False), 0.1),
    "goal not at the end": (world_of(BLOCK, goal=(1.0, 0.2)), 0.1),
    "a fork": (world_of([0.0, 0.4, 0.8, 2.0], [1.2, 0.4, 2.0, 2.0], goal=(1.0, 1.8)), 0.1),
    "a ring": (world_of([0.4, 0.4, 1.6, 1.6]), 0.1),
    "two rooms": (world_of([0.0, 0.4, 2.0, 1.6]), 0.1),
}


def test_other_worlds_are_refused():
    for world, radius in REFUSED.values():
        with pytest.raises(WorldError, match=f"^{world.name}: no chain"):
            free_chain(world, radius)
