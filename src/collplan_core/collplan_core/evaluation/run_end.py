"""The end of a run, seen in its poses."""

import numpy as np

from collplan_core.parameters import Trial

REACHED = "reached"
TIMEOUT = "timeout"
STUCK = "stuck"


class RunMonitor:
    """Follows the poses of a run from the moment the goal was given."""

    def __init__(self, goal: np.ndarray, tolerance: float, limits: Trial, begun: float) -> None:
        """`goal` (2,) and `tolerance` [m], `begun` [s] on the poses' clock."""
        self._goal = goal
        self._tolerance = tolerance
        self._limits = limits
        self._begun = begun
        self._anchor: np.ndarray | None = None
        self._anchored = begun

    def outcome(self, stamp: float, position: np.ndarray) -> str | None:
        """REACHED, TIMEOUT or STUCK, or None while the run goes on; position (2,) [m]."""
        if np.linalg.norm(position - self._goal) <= self._tolerance:
            return REACHED
        if stamp - self._begun >= self._limits.timeout:
            return TIMEOUT
        if self._anchor is None or np.linalg.norm(position - self._anchor) >= self._limits.stuck_distance:
            self._anchor, self._anchored = position, stamp
        return STUCK if stamp - self._anchored >= self._limits.stuck_time else None
