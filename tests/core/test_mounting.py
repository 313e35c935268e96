"""The mount of a LIDAR from scans of a moving robot that must agree with one another."""

import math

import numpy as np
import pytest
from driven_robots import Drive, drawn_mount, driven

from collplan_core.mounting.driven import pairs_of
from collplan_core.mounting.fit import fit_mount


@pytest.mark.parametrize("seed", range(4))
def test_a_drawn_mount_is_found_within_its_uncertainty(seed):
    true = drawn_mount(seed)
    fit = fit_mount(driven(true, Drive(), seed=seed), given=1)
    assert fit is not None
    assert fit.clear
    assert fit.known.all()
    found = fit.mount
    errors = np.abs(
        [found.late - true.late, found.x - true.x, found.y - true.y, math.remainder(found.yaw - true.yaw, math.tau)]
    )
    assert (errors < fit.uncertainty).all()
    assert found.mirrored == true.mirrored
    assert not fit.sweep_known or found.sweep == true.sweep


def test_a_robot_at_rest_shows_nothing_of_the_mount():
    recorded = driven(drawn_mount(1), Drive(moves=False), duration=6.0)
    assert len(pairs_of(recorded).scans) == 0
    assert fit_mount(recorded, given=1) is None
