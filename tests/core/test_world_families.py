"""Corridors, baffles and pillars: what every seeded world promises, whatever its shape."""

import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import shapely

from collplan_core.worlds import World, check_route, load_world
from collplan_core.worlds.families import FAMILIES
from collplan_core.worlds.placement import Layout, seeded_world
from collplan_core.worlds.route import free_space
from world_measures import BODY_RADIUS, ROUNDING, SEEDS, SIDE, open_space, worlds

NEW_FAMILIES = ("l", "u", "z", "serpentine", "baffles", "pillars")
# clear widths beside the robot [m]
NARROWEST = {"l": 0.08, "u": 0.08, "z": 0.08, "baffles": 0.10, "serpentine": 0.15, "pillars": 0.08}
WIDEST = {"l": 0.40, "u": 0.40, "z": 0.40, "baffles": 0.40, "serpentine": 0.30, "pillars": 0.50}

every_family = pytest.mark.parametrize("family", NEW_FAMILIES)


def fingerprint(world: World) -> str:
    arrays = [*world.polygons, world.circles, world.start, world.goal]
    return hashlib.sha256(b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)).hexdigest()


@every_family
def test_start_and_goal_have_room_and_are_connected(family):
    for world in worlds(family):
        check_route(world, world.start, world.goal, 0.10)
        # three standard deviations of the start's noise
        assert shapely.Point(world.start).distance(shapely.box(0, 0, SIDE, SIDE) - open_space(world)) > 0.12


@every_family
def test_every_world_is_of_thick_rectangles_in_the_paper_s_arena(family):
    for world in worlds(family):
        assert world.bounds == (0.0, 0.0, SIDE, SIDE)
        assert world.walled
        assert len(world.circles) == 0
        sizes = np.array([np.ptp(corners, axis=0) for corners in world.polygons])
        areas = [shapely.Polygon(corners).area for corners in world.polygons]
        np.testing.assert_allclose(sizes.prod(axis=1), areas)
        assert sizes.min() >= 0.04 - ROUNDING
        # as round numbers as they can be: no two machines may differ in the last bits
        assert all((np.round(corners, 4) == corners).all() for corners in world.polygons)


@every_family
def test_the_narrowest_place_is_within_the_range_of_widths(family):
    for world in worlds(family):
        assert joined(world, BODY_RADIUS + NARROWEST[family] / 2 - ROUNDING, 0.03)
        assert not joined(world, BODY_RADIUS + WIDEST[family] / 2 + ROUNDING, 0.25)


def joined(world: World, radius: float, reach: float) -> bool:
    """Whether a disc, which need not fit at start and goal, gets from within `reach` of one to as near to the other."""
    free, ends = free_space(world, radius), shapely.points([world.start, world.goal])
    return any(shapely.distance(part, ends).max() < reach for part in getattr(free, "geoms", [free]))


@every_family
def test_seeds_and_families_give_different_worlds(family):
    assert len({fingerprint(world) for world in worlds(family)}) == len(SEEDS)
    assert worlds(family)[7].name == f"{family}:7"


@every_family
def test_a_seed_gives_the_same_world_with_every_version_of_numpy(family):
    """Written down once: whoever changes a family changes every result that names one of its seeds."""
    assert fingerprint(load_world(f"{family}:7"))[:16] == EXPECTED_FINGERPRINTS[family]
    assert fingerprint(load_world(f"{family}:{2**70}"))[:16] == EXPECTED_OF_A_LARGE_SEED[family]


def test_a_seed_gives_the_same_world_in_another_process():
    code = (
        "import test_world_families as t; print(*(t.fingerprint(t.load_world(f'{f}:7'))[:16] for f in t.NEW_FAMILIES))"
    )
    here = str(Path(__file__).parent)
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=here)
    assert other.stdout.split() == [EXPECTED_FINGERPRINTS[family] for family in NEW_FAMILIES]


def test_every_family_is_tested():
    assert {*FAMILIES} == {*NEW_FAMILIES, "random", "posts"}


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
