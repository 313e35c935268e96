"""Poses as planner and controller take them."""

import numpy as np
import pytest

from collplan_core.loop.refusals import Refusals
from collplan_core.loop.sensors import Sensors
from collplan_core.parameters import Settings
from collplan_core.state import State
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.planner_node import PlannerNode


@pytest.mark.parametrize(("margin", "breaks"), [(0.05, 1), (0.2, 0)])
def test_the_margin_of_a_leap_is_the_parameter(margin, breaks):
    settings, refusals = Settings().with_values({"mocap.leap_margin": margin}), Refusals()
    sensors = Sensors(0.5, refusals)
    for stamp, x in ((5.0, 0.0), (5.01, 0.15)):
        sensors.take_pose(State(stamp, np.array([x, 0.0]), np.zeros(2), 0.0), stamp, settings)
    assert refusals["pose_break"] == breaks


@pytest.mark.parametrize("kind", [PlannerNode, ControllerNode])
def test_both_nodes_read_the_margin_of_a_leap(ros, kind):
    assert ros.make(kind, {"mocap.leap_margin": 0.2})._settings.mocap.leap_margin == 0.2
