"""The command line that repeats a run."""

import shlex
from pathlib import Path

import numpy as np
import pytest

from collplan_ros.bringup.options import Options, parse


@pytest.mark.parametrize("goal", [(2.0, 0.4), (-1e-05, -3.0)])
@pytest.mark.parametrize("network", [None, "subnet"])
def test_the_line_that_repeats_a_run_gives_robot_goal_and_parameters(goal, network):
    first = Options(robot="serial:/dev/my robot", goal=goal, network=network, timeout=9.0)
    program, *arguments = shlex.split(first.repeat(np.array(goal), Path("the runs/latest/parameters.yaml")))
    again = parse(arguments)
    assert (program, again.robot, again.goal, again.network) == ("bringup", first.robot, goal, network)
    assert again.params == Path("the runs/latest/parameters.yaml")
