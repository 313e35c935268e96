"""The change of velocity in a touch that a robot feels without measuring it."""

import math

import numpy as np


def change_by_touch(velocity: np.ndarray, towards: np.ndarray | None, restitution: float) -> np.ndarray:
    """The change of velocity (2,) [m/s], world frame; zero for a robot that does not move into the obstacle.

    Friction is left out: a side says less about the normal than friction turns the change.

    Args:
        velocity: (2,) before the touch [m/s].
        towards: (2,) unit direction to the obstacle; None where it is not felt: then it is that of the motion.
    """
    speed = math.hypot(*velocity.tolist())
    if speed == 0.0:
        return np.zeros(2)
    direction = velocity / speed if towards is None else towards
    into = float(velocity @ direction)
    return -(1.0 + restitution) * max(0.0, into) * direction
