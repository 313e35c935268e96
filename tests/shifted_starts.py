"""Trials that also start a hair aside, which every processor can do.

Two processors differ in the last bits of a number, and a closed loop makes centimetres of them. What a test says of
a trial must hold of these trials too.
"""

from dataclasses import replace

import numpy as np
import pytest

from collplan_core.worlds import World, load_world

SHIFTS = {"as is": 0.0, "shifted 1e-9": 1e-9, "shifted -2e-9": -2e-9}
"""Distances by which a start is shifted along both axes [m]."""
each_shift = pytest.mark.parametrize("shift", SHIFTS.values(), ids=SHIFTS)


def shifted(world: World | str, shift: float) -> World:
    """The world with its start so far aside along both axes [m]."""
    world = load_world(world) if isinstance(world, str) else world
    return replace(world, start=world.start + np.full(2, shift))
