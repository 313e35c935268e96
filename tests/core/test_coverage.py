"""What no accepted scan has had in view: behind a LIDAR that does not see all around, and where beams are lost."""

import math
from dataclasses import replace

import numpy as np
import pytest

from collplan_core.local_map.seen import seen_surfaces
from collplan_core.movers.coverage import CELL, REACH, with_view
from collplan_core.parameters import Settings
from collplan_core.state import State
from collplan_core.worlds import parse_world
from collplan_core.worlds.raycast import simulate_scan

SETTINGS = Settings()
HALL = parse_world({"name": "hall", "bounds": [-3.0, -3.0, 30.0, 3.0]}, "hall")
RADIUS = SETTINGS.robot.radius


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
        coverage, unseen = with_view(coverage, seen, state, RADIUS)
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
    assert np.hypot(*away.T).min() > RADIUS - CELL


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
