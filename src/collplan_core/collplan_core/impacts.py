"""The impacts of a run as one record."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Impacts:
    """Impacts of the robot on obstacles, world frame, in order of time.

    An impact is a contact begun at more than 0.08 m/s into the wall; contacts within 50 ms of it on the same surface
    belong to it.

    Attributes:
        times: (k,) [s].
        points: (k, 2) where the ring touches the obstacle [m].
        normals: (k, 2) unit normals out of the obstacle.
        velocities_before: (k, 2) [m/s].
        velocities_after: (k, 2) [m/s].
    """

    times: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    velocities_before: np.ndarray
    velocities_after: np.ndarray

    def __len__(self) -> int:
        return len(self.times)

    @staticmethod
    def none() -> "Impacts":
        """No impact."""
        return Impacts(np.zeros(0), *(np.zeros((0, 2)) for _ in range(4)))
