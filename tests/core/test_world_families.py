"""Corridors, baffles and pillars: what every seeded world promises, whatever its shape."""

import hashlib
from functools import cache

import numpy as np
import shapely

from collplan_core.worlds import World, check_route, load_world
from collplan_core.worlds.families import FAMILIES
from collplan_core.worlds.placement import Layout, seeded_world
from collplan_core.worlds.route import free_space

SEEDS = range(40)
SIDE = 2.4
BODY_RADIUS = 0.09
# coordinates are rounded to 0.1 mm, so a width is off by up to as much
ROUNDING = 1.1e-4

FAMILIES_TESTED = ("l", "u", "z", "serpentine", "baffles", "pillars")
# clear widths beside the robot [m]
NARROWEST = {"l": 0.08, "u": 0.08, "z": 0.08, "baffles": 0.10, "serpentine": 0.15, "pillars": 0.08}
WIDEST = {"l": 0.40, "u": 0.40, "z": 0.40, "baffles": 0.40, "serpentine": 0.30, "pillars": 0.50}


@cache
def worlds(family: str) -> tuple[World, ...]:
    return tuple(load_world(f"{family}:{seed}") for seed in SEEDS)


def open_space(world: World) -> shapely.Geometry:
    return shapely.box(*world.bounds).difference(shapely.union_all([shapely.Polygon(p) for p in world.polygons]))


def fingerprint(world: World) -> str:
    arrays = [*world.polygons, world.circles, world.start, world.goal]
    return hashlib.sha256(b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)).hexdigest()


def test_start_and_goal_have_room_and_the_narrowest_place_is_within_the_range_of_widths():
    for world in (world for family in FAMILIES_TESTED for world in worlds(family)):
        family = world.name.split(":")[0]
        check_route(world, world.start, world.goal, 0.10)
        # three standard deviations of the start's noise
        room = shapely.Point(world.start).distance(shapely.box(0, 0, SIDE, SIDE) - open_space(world))
        assert room > 0.12, world.name
        assert joined(world, BODY_RADIUS + NARROWEST[family] / 2 - ROUNDING, 0.03), world.name
        assert not joined(world, BODY_RADIUS + WIDEST[family] / 2 + ROUNDING, 0.25), world.name


def joined(world: World, radius: float, reach: float) -> bool:
    """Whether a disc, which need not fit at start and goal, gets from within `reach` of one to as near to the other."""
    free, ends = free_space(world, radius), shapely.points([world.start, world.goal])
    return any(shapely.distance(part, ends).max() < reach for part in getattr(free, "geoms", [free]))


def test_a_seed_gives_the_same_world_in_every_process_and_with_every_version_of_numpy():
    """Written down once: whoever changes a family changes every result that names one of its seeds."""
    assert {*FAMILIES} == {*FAMILIES_TESTED, "random", "posts"}
    for family in FAMILIES_TESTED:
        assert len({fingerprint(world) for world in worlds(family)}) == len(SEEDS), family
        assert worlds(family)[7].name == f"{family}:7"
        assert fingerprint(load_world(f"{family}:7"))[:16] == EXPECTED_FINGERPRINTS[family], family
        assert fingerprint(load_world(f"{family}:{2**70}"))[:16] == EXPECTED_OF_A_LARGE_SEED[family], family


def test_nothing_but_the_corridor_is_free():
    for family, corners in (("l", 6), ("u", 8), ("z", 8), ("serpentine", 16)):
        for world in worlds(family):
            corridor = open_space(world)
            assert (corridor.geom_type, len(corridor.interiors)) == ("Polygon", 0), world.name
            assert len(corridor.simplify(1e-9).exterior.coords) - 1 == corners, world.name
            assert corridor.distance(shapely.box(*world.bounds).exterior) >= 0.05 - ROUNDING, world.name


def aside_of_the_middle(draw) -> Layout:
    return Layout(np.array([[1.0, 1.0, 1.2, 1.4]]), np.array([0.2, 0.5]), np.array([2.1, 2.0]))


def test_a_layout_is_mirrored_and_turned_every_way():
    placed = [seeded_world("aside", aside_of_the_middle, seed) for seed in range(64)]
    starts = {tuple(world.start.tolist()) for world in placed}
    values = (0.2, 0.5, 2.2, 1.9)
    assert starts == {(a, b) for a in values for b in values if {a, b} & {0.2, 2.2} and {a, b} & {0.5, 1.9}}
    for world in placed:
        distances = [np.hypot(*(corner - point)) for corner in world.polygons[0] for point in (world.start, world.goal)]
        expected = np.hypot([0.8, 1.1, 1.0, 0.9, 1.0, 0.9, 0.8, 1.1], [0.5, 1.0, 0.5, 1.0, 0.9, 0.6, 0.9, 0.6])
        np.testing.assert_allclose(np.sort(distances), np.sort(expected), atol=2e-4)


EXPECTED_FINGERPRINTS = {
    "l": "1ea303d4046fb83d",
    "u": "5ff6305ef91f771d",
    "z": "d4e40453c537fd00",
    "serpentine": "aa1ecc73a5b888e6",
    "baffles": "237d1f6cbb49df04",
    "pillars": "720aca6712931d2d",
}
EXPECTED_OF_A_LARGE_SEED = {
    "l": "c1e859b7a29d9751",
    "u": "0798445d6ef67863",
    "z": "b5587ce061a75fa8",
    "serpentine": "bdac06534f2ff344",
    "baffles": "b3a7b66f8cde1b76",
    "pillars": "9fc3a640a2556785",
}
