"""The lower bound of a world's time, below every motion that keeps the limits, and the chain of boxes it rests on."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.worlds import World, WorldError, load_world
from collplan_core.worlds.route import QUARTER_SEGMENTS, free_space
from optimum.disc import Disc
from optimum.free_chain import FreeChain, Region, free_chain
from optimum.lower_bound import lower_bound, rest_to_free, rest_to_rest, turning_points
from optimum.options import FAMILIES

SPEED, ACCELERATION = 1.2, 1.5
DISC = Disc(0.09, SPEED, ACCELERATION, 0.1)


def chain_of(*boxes: tuple[float, float, float, float], start: tuple, goal: tuple) -> FreeChain:
    """A chain whose boxes are given, x0, y0, x1, y1; the bound asks nothing of the corners."""
    regions = tuple(Region(np.array(box[:2]), np.array(box[2:])) for box in boxes)
    return FreeChain(regions, np.array(start), np.array(goal))


def test_rest_to_rest_and_rest_to_free_by_hand():
    # 0.12 m in 0.4 s up to 0.6 m/s, and back to rest; just up to full speed; 1.2 m more at full speed
    for distance, time in [(0.0, 0.0), (0.24, 0.8), (0.96, 1.6), (2.16, 2.6)]:
        assert rest_to_rest(distance, SPEED, ACCELERATION) == pytest.approx(time), distance
    for distance, time in [(0.0, 0.0), (0.12, 0.4), (0.48, 0.8), (1.68, 1.8)]:
        assert rest_to_free(distance, SPEED, ACCELERATION) == pytest.approx(time), distance


def test_turning_points_by_hand():
    for visits, points in [
        ([], [0.0, 0.0]),
        ([(-1.0, 1.0), (-2.0, 0.5)], [0.0, 0.0]),
        ([(1.0, 2.0), (3.0, 4.0), (2.0, 5.0)], [0.0, 3.0]),
        ([(1.0, 2.0), (-5.0, 0.5), (0.0, 3.0)], [0.0, 1.0, 0.5]),
        ([(-3.0, -1.0), (0.0, 2.0), (1.0, 2.0), (-9.0, -2.0)], [0.0, -1.0, 1.0, -2.0]),
    ]:
        assert turning_points(0.0, visits) == points, visits


def test_a_u_takes_the_way_over_its_tip_and_back():
    chain = chain_of(
        (0.0, 0.0, 1.0, 0.2), (0.9, 0.0, 1.0, 0.6), (0.0, 0.4, 1.0, 0.6), start=(0.0, 0.1), goal=(0.0, 0.5)
    )
    # 0.9 m to the tip, from rest to rest; 0.8 m back to the goal, the last 0.32 m at full speed
    assert lower_bound(chain, DISC) == pytest.approx(2 * math.sqrt(0.9 / 1.5) + 0.8 + 0.32 / 1.2)


@st.composite
def motions(draw) -> tuple[float, np.ndarray]:
    """Duration and positions (n,) of a motion along a line that begins at rest and keeps the limits."""
    velocities = np.array([0.0, *draw(st.lists(st.floats(-SPEED, SPEED), min_size=1, max_size=8))])
    coasting = draw(st.lists(st.floats(0.0, 1.0), min_size=len(velocities) - 1, max_size=len(velocities) - 1))
    # at one acceleration from each velocity to the next, at most the largest
    steps = np.abs(np.diff(velocities)) / ACCELERATION + coasting
    ways = (velocities[1:] + velocities[:-1]) / 2 * steps
    return float(steps.sum()), np.cumsum(ways)


@given(motion=motions(), margins=st.lists(st.tuples(st.floats(0.0, 0.5), st.floats(0.0, 0.5)), min_size=8, max_size=8))
def test_no_motion_beats_it(motion, margins):
    duration, positions = motion
    visits = [(x - below, x + above) for x, (below, above) in zip(positions, margins, strict=False)]
    chain = chain_of(*((low, 0.0, high, 1.0) for low, high in visits), start=(0.0, 0.5), goal=(positions[-1], 0.5))
    assert lower_bound(chain, DISC) <= duration + 1e-9


ARC = 2e-5
"""shapely's arcs are off by less than this [m]."""


def area_of(region: Region, radius: float) -> shapely.Geometry:
    rectangle = shapely.box(*region.low, *region.high)
    if region.vertex is None:
        return rectangle
    return rectangle.difference(shapely.Point(region.vertex).buffer(radius, quad_segs=QUARTER_SEGMENTS))


def joined(area: shapely.Geometry, *points: np.ndarray) -> bool:
    return any(all(piece.covers(shapely.Point(p)) for p in points) for piece in getattr(area, "geoms", [area]))


def world_of(*solids: list[float], start=(0.2, 0.2), goal=(1.8, 1.8)) -> World:
    """A room of 2 m x 2 m with solid rectangles x0, y0, x1, y1 in it."""
    corners = [np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) for x0, y0, x1, y1 in solids]
    return World("room", tuple(corners), np.zeros((0, 3)), (0, 0, 2, 2), start=np.array(start), goal=np.array(goal))


BLOCK = [0.0, 0.4, 1.6, 2.0]
"""In that room it leaves an l, 0.4 m wide."""


@given(family=st.sampled_from(FAMILIES), seed=st.integers(0, 2**40), radius=st.floats(0.02, 0.12))
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


REFUSED = {
    "circles and slopes": (load_world("random:3"), 0.09),
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
