"""Restitution and friction of each hit of the simulated robot."""

from collections.abc import Iterable

import numpy as np

from collplan_core.parameters import Simulation
from omnipuck_sim.robot.vector import Vector

IMPACT_SPEED = 0.08
"""A contact begun faster than this into the wall is recorded as an impact [m/s]."""


class HitLaw:
    """Restitution may differ from wall to wall, restitution and friction from hit to hit."""

    def __init__(self, simulation: Simulation, surfaces: Iterable[int], random: np.random.Generator) -> None:
        """`random` draws the spread of each of the numbered surfaces, and of each hit."""
        self._simulation, self._random = simulation, random
        numbers = sorted(set(surfaces))
        draws = random.uniform(-1.0, 1.0, len(numbers)).tolist()
        self._factors = {
            number: 1.0 + simulation.wall_spread * draw for number, draw in zip(numbers, draws, strict=True)
        }

    def drawn(self) -> Vector:
        """Returns the random numbers of one hit."""
        spread, rough = self._random.uniform(-1.0, 1.0, 2).tolist()
        return spread, rough

    def of(self, surface: int, drawn: Vector) -> tuple[float, float]:
        """Restitution and friction of a hit on a surface."""
        simulation, (spread, rough) = self._simulation, drawn
        restitution = simulation.restitution * self._factors[surface] + spread * simulation.restitution_spread
        friction = simulation.friction + rough * simulation.friction_spread
        return min(max(restitution, 0.0), 1.0), max(friction, 0.0)
