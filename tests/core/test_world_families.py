"""Seeded worlds: what each family promises, and that a seed means one world everywhere."""

import hashlib
from functools import cache
from itertools import combinations

import numpy as np
import shapely

from collplan_core.worlds import World, check_route, load_world
from collplan_core.worlds.families import FAMILIES
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


def cores(world: World) -> list[tuple[shapely.Geometry, float]]:
    """Each obstacle as a geometry and how far it reaches around it, so that distances to circles are exact."""
    polygons = [(shapely.Polygon(corners), 0.0) for corners in world.polygons]
    return polygons + [(shapely.Point(x, y), radius) for x, y, radius in world.circles]


def gaps(world: World) -> list[float]:
    """Distance between any two obstacles and from each to the walls; zero or less where they meet."""
    between = [a.distance(b) - ra - rb for (a, ra), (b, rb) in combinations(cores(world), 2)]
    walls = shapely.box(*world.bounds).exterior
    return between + [shape.distance(walls) - reach for shape, reach in cores(world)]


def test_every_gap_in_random_is_closed_or_lets_the_disc_through_and_opposite_corners_are_connected():
    middle = np.array([1.2, 1.2])
    for world in (load_world(f"random:{seed}") for seed in (*range(12), 2**40)):
        assert not [gap for gap in gaps(world) if 0.0 < gap < 0.2]
        check_route(world, world.start, world.goal, 0.10)
        assert ((world.start - middle) * (world.goal - middle) < 0.0).all()
        assert np.hypot(*(world.goal - world.start)) > 1.2


def test_posts_are_round_thin_and_stand_in_a_wall_or_a_centimetre_more_than_the_robot_apart():
    narrowest = []
    for world in (load_world(f"posts:{seed}") for seed in (*range(12), 2**40)):
        assert (len(world.polygons), 15 <= len(world.circles) <= 40) == (0, True), world.name
        assert 0.03 <= world.circles[:, 2].min() <= world.circles[:, 2].max() <= 0.08
        narrowest.append(min(gap for gap in gaps(world) if gap > 0.0))
        check_route(world, world.start, world.goal, 0.09)
    assert min(narrowest) >= 0.19 - 1e-9
    assert np.median(narrowest) < 0.20  # in most worlds some gap is hardly wider than the robot


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
    assert {*FAMILIES} == {*EXPECTED_FINGERPRINTS, "posts"}
    for family, expected in EXPECTED_FINGERPRINTS.items():
        assert load_world(f"{family}:7").name == f"{family}:7"
        assert fingerprint(load_world(f"{family}:7"))[:16] == expected, family
    for family in FAMILIES_TESTED:
        assert len({fingerprint(world) for world in worlds(family)}) == len(SEEDS), family
    assert fingerprint(load_world(f"l:{2**70}"))[:16] == "c1e859b7a29d9751"


def test_nothing_but_the_corridor_is_free():
    for family, corners in (("l", 6), ("u", 8), ("z", 8), ("serpentine", 16)):
        for world in worlds(family):
            corridor = open_space(world)
            assert (corridor.geom_type, len(corridor.interiors)) == ("Polygon", 0), world.name
            assert len(corridor.simplify(1e-9).exterior.coords) - 1 == corners, world.name
            assert corridor.distance(shapely.box(*world.bounds).exterior) >= 0.05 - ROUNDING, world.name


EXPECTED_FINGERPRINTS = {
    "random": "42e128e4c98034ee",
    "l": "1ea303d4046fb83d",
    "u": "5ff6305ef91f771d",
    "z": "d4e40453c537fd00",
    "serpentine": "aa1ecc73a5b888e6",
    "baffles": "237d1f6cbb49df04",
    "pillars": "720aca6712931d2d",
}
