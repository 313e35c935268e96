"""Robots that get stuck for real: what they run into is not what the LIDAR sees."""

import numpy as np
import pytest
from shifted_starts import each_shift, shifted

from collplan_core.evaluation.run_end import ABORTED, REACHED
from collplan_core.parameters import Settings
from collplan_core.worlds import World, parse_world
from omnipuck_sim.trial import run_trial

ENDS = {"bounds": [0.0, 0.0, 3.0, 1.6], "start": [0.3, 0.8], "goal": [2.7, 0.8]}


def room(*boxes: tuple[float, float, float, float]) -> World:
    corners = [[[a, b], [c, b], [c, d], [a, d]] for a, b, c, d in boxes]
    return parse_world({"name": "room", "polygons": corners, **ENDS}, "room")


POCKET = room((1.4, 0.58, 1.5, 1.02), (1.2, 0.58, 1.4, 0.68), (1.2, 0.92, 1.4, 1.02))
"""Open toward the robot, 3 cm wider than it on either side."""
CLOSED = room((1.4, 0.0, 1.5, 1.6))
"""No way to the goal."""


def trial(strategy: str, solid: World, shift: float = 0.0, seed: int = 1):
    settings = Settings().with_values({"planner.strategy": strategy})
    return run_trial(shifted(room(), shift), settings, seed, solid=shifted(solid, shift))


@each_shift
def test_a_robot_in_a_pocket_that_it_does_not_see_backs_out_and_goes_round(shift):
    """With so few tries not always: simulated, 12 of 16 with bounce."""
    result = trial("bounce", POCKET, shift, seed=2)
    x, y = result.trajectory[:, 1:3].T
    assert ((x > 1.25) & (np.abs(y - 0.8) < 0.1)).any()
    assert len(result.impacts) > 0
    assert result.outcome == REACHED


@pytest.mark.parametrize("strategy", ["harness", pytest.param("bounce", marks=pytest.mark.soak)])
def test_a_robot_that_finds_no_way_gives_up_after_some_tries(strategy):
    result = trial(strategy, CLOSED)
    assert result.outcome == ABORTED
    # it tried at other places than the first
    at_wall = result.trajectory[result.trajectory[:, 1] > 1.25]
    assert np.ptp(at_wall[:, 2]) > 0.3
