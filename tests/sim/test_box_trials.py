"""Trials of a robot whose axes are limited each on its own."""

import numpy as np
from shifted_starts import each_shift, shifted

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from omnipuck_sim.trial import run_trial

OPEN = World("open", (), np.zeros((0, 3)), (-1.0, -1.0, 8.0, 8.0), start=np.zeros(2), goal=np.array([6.0, 6.0]))
V_MAX = Settings().robot.max_speed


def trial(world, shape: str, shift: float = 0.0, **values):
    chosen = {key.replace("__", "."): value for key, value in values.items()}
    return run_trial(shifted(world, shift), Settings().with_values({"robot.velocity_shape": shape, **chosen}), seed=1)


@each_shift
def test_bounce_reaches_the_goal_of_a_serpentine(shift):
    result = trial("serpentine:2", "box", shift, planner__strategy="bounce")
    assert result.reached
    assert result.deliberate.any()
    speeds = np.hypot(*result.commands[:, 1:3].T)
    assert np.abs(result.commands[:, 1:3]).max() <= V_MAX * (1 + 1e-9)
    assert speeds.max() > 1.2 * V_MAX
