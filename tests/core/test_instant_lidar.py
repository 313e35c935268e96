"""The LIDAR whose beams are of one instant: exact, or with the noise of `lidar.range_noise`."""

import numpy as np
import pytest

from collplan_core.parameters import Lidar
from collplan_core.sensing.instant_lidar import InstantLidar
from scenes import at_rest, scan_of, world_of

ROOM = world_of(bounds=(-1.0, -1.0, 1.0, 1.0), walled=True)


def noisy(noise: float, seed: int = 3) -> InstantLidar:
    return InstantLidar(ROOM, Lidar(range_noise=noise), seed)


def test_without_noise_it_is_exact():
    assert noisy(0.0).scan(at_rest()).ranges.tobytes() == scan_of(ROOM, at_rest()).ranges.tobytes()


def test_noise_has_its_deviation_and_no_mean():
    lidar, exact = noisy(0.01), scan_of(ROOM, at_rest())
    errors = np.array([lidar.scan(at_rest()).ranges - exact.ranges for _ in range(20)])
    # four standard errors
    assert errors.std() == pytest.approx(0.01, rel=4 / np.sqrt(2 * errors.size))
    assert abs(errors.mean()) < 4 * 0.01 / np.sqrt(errors.size)


def test_equal_seeds_give_equal_scans_and_no_two_scans_are_equal():
    lidar, again, other = noisy(0.01), noisy(0.01), noisy(0.01, seed=4)
    first = lidar.scan(at_rest()).ranges.tobytes()
    assert first == again.scan(at_rest()).ranges.tobytes()
    assert first != other.scan(at_rest()).ranges.tobytes()
    assert first != lidar.scan(at_rest()).ranges.tobytes()


def test_beams_that_meet_nothing_or_are_too_near_stay_so():
    lidar = InstantLidar(world_of(), Lidar(range_noise=0.01), 0)
    assert np.isposinf(lidar.scan(at_rest()).ranges).all()
    outside = InstantLidar(ROOM, Lidar(range_noise=0.01), 0).scan(at_rest((2.0, 0.0)))
    assert np.isneginf(outside.ranges).all()
