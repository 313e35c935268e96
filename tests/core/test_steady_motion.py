"""A base that follows its commands along x alone is named."""

import numpy as np
import pytest

from collplan_core.control.steady_motion import SteadyMotion
from collplan_core.state import State

YAW = 0.7


@pytest.mark.parametrize(
    ("shares", "named"), [((1.0, 0.0), True), ((0.9, 0.05), True), ((1.0, 0.6), False), ((0.0, 0.0), False)]
)
def test_a_base_that_cannot_drive_sideways_is_named(shares, named):
    steady, told = SteadyMotion(), np.array([0.5, -0.4])
    turn = np.array([[np.cos(YAW), -np.sin(YAW)], [np.sin(YAW), np.cos(YAW)]])
    for k in range(100):
        steady.take_command(told, 0.02 * k)
        steady.take_pose(State(0.02 * k, np.zeros(2), turn @ (told * shares), YAW), free=True)
    assert steady.why_unlike == ("moves along x alone: can the base drive sideways?" if named else "")
