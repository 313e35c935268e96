"""The rebound off an obstacle: v' = -e v_n n + k_t v_t, spin unchanged.

Written apart from the planner's model of the same law: this is the truth that the model is tested against.
"""

from dataclasses import dataclass

import numpy as np

from collplan_core.parameters import Simulation
from collplan_core.plane import rotate
from omnipuck_sim.robot.vector import Vector

IMPACT_SPEED = 0.08
"""A contact begun faster than this into the wall is an impact; a slower one slides [m/s]."""


@dataclass(frozen=True, eq=False)
class Impact:
    """One impact, world frame.

    Attributes:
        time: when it was [s, simulated].
        point: (2,) contact point on the obstacle [m].
        normal: (2,) unit normal out of the obstacle.
        velocity_before, velocity_after: (2,) velocity of the robot [m/s].
    """

    time: float
    point: np.ndarray
    normal: np.ndarray
    velocity_before: np.ndarray
    velocity_after: np.ndarray


def closing_speed(velocity: Vector, normal: Vector) -> float:
    """Speed into the wall whose unit normal points out of it [m/s]."""
    return -(velocity[0] * normal[0] + velocity[1] * normal[1])


def rebound(velocity: Vector, normal: Vector, restitution: float, tangential_retention: float) -> Vector:
    """Velocity after an impact at `velocity` [m/s] on a wall with this unit normal.

    >>> rebound((3.0, -1.0), (0.0, 1.0), 0.5, 1.0)
    (3.0, 0.5)
    """
    into = closing_speed(velocity, normal)
    along = (velocity[0] + into * normal[0], velocity[1] + into * normal[1])
    return (
        tangential_retention * along[0] + restitution * into * normal[0],
        tangential_retention * along[1] + restitution * into * normal[1],
    )


def slide(velocity: Vector, normal: Vector) -> Vector:
    """Velocity without its share into the wall; the rest is kept."""
    into = max(closing_speed(velocity, normal), 0.0)
    return velocity[0] + into * normal[0], velocity[1] + into * normal[1]


class Ring:
    """The reflection ring in truth: restitution and direction may spread from impact to impact."""

    def __init__(self, settings: Simulation, random: np.random.Generator) -> None:
        self._settings = settings
        self._random = random

    def velocity_after(self, velocity: Vector, normal: Vector) -> Vector:
        """Velocity after an impact [m/s]; never into the wall, never faster than before."""
        s = self._settings
        spread, turn = self._random.uniform(-1.0, 1.0, 2).tolist()
        restitution = min(max(s.restitution + spread * s.restitution_spread, 0.0), 1.0)
        after = rebound(velocity, normal, restitution, s.tangential_retention)
        if s.direction_spread == 0.0:
            return after
        return slide(rotate(*after, turn * s.direction_spread), normal)
