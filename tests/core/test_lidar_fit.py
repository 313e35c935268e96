"""The LIDAR's place on the robot, found from what it shows of a known world."""

import math

import numpy as np
import pytest

from collplan_core.calibration.lidar_fit import fit_mount
from collplan_core.parameters import Lidar
from collplan_core.sensing.spinning_lidar import LD19, swept_scan
from collplan_core.state import State
from collplan_core.worlds.raycast import simulate_scan
from scenes import at_rest, box, world_of

ROOM = world_of(
    [box(1.2, 0.2, 1.6, 0.5), box(0.1, 1.3, 0.3, 1.8)],
    [(2.1, 1.6, 0.15)],
    bounds=(0.0, 0.0, 2.6, 2.2),
    walled=True,
)
"""What somebody may put on a floor: a box, a board, a bucket, and no symmetry."""


def resting(world, lidar: Lidar, random, n: int = 6):
    """Scans of a low-cost sensor on a robot at rest near one place, whose measured pose is off by its noise."""
    scans = []
    for _ in range(n):
        x, y = np.array([0.9, 0.9]) + random.uniform(-0.1, 0.1, 2)
        yaw = random.uniform(-0.1, 0.1) + 0.7
        poses = np.tile((x, y, yaw), (LD19.n_beams, 1))
        measured = State(
            0.0, np.array([x, y]) + random.normal(0.0, 0.002, 2), np.zeros(2), yaw + random.normal(0, 0.004)
        )
        scans.append((swept_scan(world, poses, 0.0, LD19, lidar, random), measured))
    return scans


@pytest.mark.parametrize("seed", range(20))
def test_a_lidar_turned_shifted_or_mirrored_is_found(seed):
    random = np.random.default_rng(seed)
    x, y = random.uniform(-0.08, 0.08, 2).tolist()
    yaw = float(random.uniform(-math.pi, math.pi))
    truth = Lidar(offset_x=x, offset_y=y, offset_yaw=yaw, mirrored=bool(seed % 2))
    fit = fit_mount(resting(ROOM, truth, random), ROOM)
    assert fit.mount.mirrored == truth.mirrored
    assert abs(math.remainder(fit.mount.yaw - yaw, math.tau)) < math.radians(0.6)
    assert math.hypot(fit.mount.x - x, fit.mount.y - y) < 0.006
    assert fit.explained > 0.9
    assert fit.rival < fit.explained - 0.2
    assert (fit.uncertainty < 0.005).all()


def test_what_is_not_in_the_world_file_does_not_matter_while_most_is():
    random = np.random.default_rng(3)
    truth = Lidar(offset_x=0.03, offset_yaw=1.0)
    there = world_of([*ROOM.polygons, box(0.4, 1.2, 0.5, 1.3)], ROOM.circles, ROOM.bounds, walled=True)
    fit = fit_mount(resting(there, truth, random), ROOM)
    assert abs(fit.mount.yaw - 1.0) < math.radians(0.6)
    assert abs(fit.mount.x - 0.03) < 0.006
    assert 0.7 < fit.explained < 0.97


def test_another_room_is_not_explained():
    random = np.random.default_rng(4)
    other = world_of([box(1.9, 0.3, 2.2, 0.8)], bounds=(-0.6, 0.1, 3.5, 1.5), walled=True)
    fit = fit_mount(resting(other, Lidar(), random), ROOM)
    assert fit.explained < 0.7


def test_where_a_room_looks_the_same_from_another_heading_there_is_a_rival():
    square = world_of(bounds=(-1.0, -1.0, 1.0, 1.0), walled=True)
    fit = fit_mount([(simulate_scan(square, at_rest(), Lidar(offset_yaw=0.4)), at_rest())], square)
    assert fit.rival > 0.99 * fit.explained


def test_without_hits_or_surfaces_there_is_nothing_to_say():
    state = at_rest((0.9, 0.9))
    assert fit_mount([], ROOM) is None
    assert fit_mount([(simulate_scan(ROOM, state, Lidar(n_beams=60)), state)], ROOM) is None
    assert fit_mount([(simulate_scan(ROOM, state, Lidar()), state)], world_of()) is None
