"""The edges of what a scan does not show: who comes out of there crosses one, and closed walls have none."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import shapely

from collplan_core.local_map import build_local_map
from collplan_core.movers.unseen import NARROW, unseen_edges
from collplan_core.parameters import Settings
from collplan_core.state import State
from collplan_core.worlds import load_world, parse_world
from collplan_core.worlds.raycast import simulate_scan
from collplan_core.worlds.route import free_space

SETTINGS = Settings()
ROOM = parse_world({"name": "room", "bounds": [-1.5, -1.0, 2.0, 1.0]}, "room")
BOX = parse_world(
    {"name": "box", "bounds": [-1.5, -1.0, 2.0, 1.0], "polygons": [[[0.8, -0.2], [1.1, -0.2], [1.1, 0.2], [0.8, 0.2]]]},
    "box",
)
START = State(0.0, np.zeros(2), np.zeros(2), 0.0)


def scan_in(world, state=START, **changed):
    return simulate_scan(world, state, replace(SETTINGS.lidar, **changed))


def edges_of(scan, state=START):
    shown = build_local_map(scan, state, SETTINGS.robot, SETTINGS.local_map)
    return unseen_edges(shown.view, shown.view_from, shown.view_beams, shown.walls, scan.range_max)


def without(scan, of, to):
    """The scan with beams that measured nothing."""
    ranges = scan.ranges.copy()
    ranges[of:to] = np.nan
    return replace(scan, ranges=ranges)


def test_a_closed_room_has_none_and_behind_a_box_there_are_two():
    assert len(edges_of(scan_in(ROOM))) == 0
    edges = edges_of(scan_in(BOX))
    assert len(edges) == 2
    np.testing.assert_allclose(np.sort(edges[:, [0, 2]], axis=1), [(0.8, 2.0)] * 2, atol=0.01)
    np.testing.assert_allclose(np.abs(edges[:, [1, 3]]).min(axis=1), (0.2, 0.2), atol=0.01)


def test_few_lost_beams_hide_nothing_and_many_hide_what_begins_at_the_sensor():
    scan = scan_in(ROOM)
    assert len(edges_of(without(scan, 90, 93))) == 0
    edges = edges_of(without(scan, 90, 130))
    assert len(edges) == 2
    np.testing.assert_allclose(edges[:, :2], 0.0, atol=1e-9)


def test_beyond_the_farthest_range_and_beside_the_field_of_view_something_may_come_from():
    far = edges_of(scan_in(ROOM, range_max=1.2))
    bearings, ranges = np.arctan2(far[:, 1], far[:, 0]), np.hypot(far[:, 0], far[:, 1])
    assert (np.abs(bearings) < 0.7).any()
    assert ((ranges > 1.0) & (ranges <= 1.2 + 1e-9)).all()
    half = edges_of(scan_in(ROOM, angle_min=-0.5 * math.pi, angle_span=math.pi))
    assert len(half) == 2
    np.testing.assert_allclose(half[:, 2], 0.0, atol=0.02)


@pytest.mark.parametrize("family", ["random", "baffles", "serpentine", "u"])
def test_who_comes_into_view_crosses_an_edge(family):
    random, crossings = np.random.default_rng(5), 0
    for seed in range(5):
        world = load_world(f"{family}:{seed}")
        room, places = free_space(world, 0.1), random.uniform(world.bounds[:2], world.bounds[2:], (300, 2))
        places = places[shapely.contains_xy(room, places)]
        state = replace(START, position=places[0])
        scan = scan_in(world, state)
        seen = shapely.Polygon(scan.points(state, np.isfinite(scan.ranges))).buffer(0)
        edges = shapely.union_all(shapely.linestrings(edges_of(scan, state).reshape(-1, 2, 2)))
        hidden = [place for place in places if seen.distance(shapely.Point(place)) > NARROW]
        for start, end in product(hidden[:40], places[:40]):
            way = shapely.LineString([start, end])
            if room.contains(way) and seen.contains(shapely.Point(end)):
                assert way.distance(edges) < 0.5 * NARROW, (world.name, start, end)
                crossings += 1
    assert crossings > 20
