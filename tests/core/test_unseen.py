"""The edges of what a scan does not show: who comes out of there crosses one, and closed walls have none."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import shapely

from collplan_core.local_map import build_local_map
from collplan_core.local_map.seen import seen_surfaces
from collplan_core.movers.coverage import CELL, REACH, with_view
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


def test_a_closed_room_has_none_and_behind_a_box_there_are_two():
    assert len(edges_of(scan_in(ROOM))) == 0
    edges = edges_of(scan_in(BOX))
    assert len(edges) == 2
    np.testing.assert_allclose(np.sort(edges[:, [0, 2]], axis=1), [(0.8, 2.0)] * 2, atol=0.01)
    np.testing.assert_allclose(np.abs(edges[:, [1, 3]]).min(axis=1), (0.2, 0.2), atol=0.01)


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


HALL = parse_world({"name": "hall", "bounds": [-3.0, -3.0, 30.0, 3.0]}, "hall")


def at(x=0.0, y=0.0, yaw=0.0) -> State:
    return State(0.0, np.array([x, y]), np.zeros(2), yaw)


def sees(states, degrees, world=HALL, lost=()):
    """What scans of a LIDAR of so many degrees leave unseen, taken one after the other; beams (from, to) are lost."""
    coverage, unseen, span = None, None, math.radians(degrees)
    lidar = replace(SETTINGS.lidar, angle_min=-0.5 * span, angle_span=span)
    for state in states:
        scan = simulate_scan(world, state, lidar)
        ranges = scan.ranges.copy()
        for begin, end in lost:
            ranges[begin:end] = np.nan
        seen = seen_surfaces(replace(scan, ranges=ranges), state)
        coverage, unseen = with_view(coverage, seen, state, SETTINGS.robot.radius)
    return unseen


@pytest.mark.parametrize("degrees", [270, 180, 70])
@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_what_lies_in_the_sector_left_out_is_unseen_and_nothing_else(degrees, yaw):
    unseen = sees([at(0.2, 0.1, yaw)], degrees)
    away = unseen.places - (0.2, 0.1)
    bearings = np.abs(np.remainder(np.arctan2(*away.T[::-1]) - yaw + math.pi, math.tau) - math.pi)
    assert math.degrees(unseen.blind) == pytest.approx(360 - degrees, abs=2)
    assert math.remainder(unseen.faces, math.tau) == pytest.approx(0.0, abs=0.03)
    assert bearings.min() > math.radians(0.5 * degrees) - 1e-6
    assert len(away) * CELL**2 == pytest.approx(math.pi * REACH**2 * (1.0 - degrees / 360), rel=0.05)
    assert np.hypot(*away.T).min() > SETTINGS.robot.radius - CELL


def test_all_around_and_with_few_lost_beams_nothing_is_unseen_and_many_lost_ones_hide_their_sector():
    n = SETTINGS.lidar.n_beams
    for lost in ((), ((10, 11),), ((0, 1),), ((n - 1, n),)):
        assert len(sees([at()], 360, lost=lost).places) == 0
    unseen = sees([at()], 360, lost=((n // 2 - n // 12, n // 2 + n // 12),))
    assert (unseen.places[:, 0] > 0.0).all()
    assert abs(unseen.faces) == pytest.approx(math.pi, abs=0.05)


def test_what_an_earlier_scan_had_in_view_stays_seen_also_after_a_long_way():
    there_and_back = [at(x) for x in (0.0, 0.4, 0.8)] + [at(0.0)]
    assert not (np.abs(sees(there_and_back, 180).places - (0.4, 0.0)) < 0.3).all(axis=1).any()
    assert (sees([at(0.0)], 180).places[:, 0] < 0.01).all()
    far = [at(x) for x in np.arange(0.0, 25.0, 0.5)]
    behind = sees(far, 180).places - far[-1].position
    assert (np.abs(behind[:, 0]) < CELL).all()
    assert len(sees([*far, at(24.5, 0.0, math.pi), at(0.0)], 180).places) > 0


def test_what_hides_behind_a_wall_is_unseen_only_out_of_view_and_nothing_comes_out_of_the_wall():
    box = [[0.8, -0.6], [1.0, -0.6], [1.0, 0.6], [0.8, 0.6]]
    world = parse_world({"name": "box", "bounds": [-3.0, -3.0, 3.0, 3.0], "polygons": [box]}, "box")
    assert len(sees([at()], 360, world).places) == 0
    turned = sees([at(), at(yaw=math.pi)], 180, world)
    hidden = (turned.places[:, 0] > 1.0) & (np.abs(turned.places[:, 1]) < 0.5)
    beside = (turned.edges[:, 0] > 0.8) & (turned.edges[:, 0] < 0.95) & (np.abs(turned.edges[:, 1]) < 0.5)
    assert hidden.any()
    assert not beside.any()
