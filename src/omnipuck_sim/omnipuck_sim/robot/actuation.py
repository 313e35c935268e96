"""The wheels' response to a commanded velocity: dv/dt = (u - v) / lag, at most max_acceleration.

Written apart from the planner's model of the same law: this is the truth that the model is tested against.
"""

from math import exp, hypot

from collplan_core.parameters import Robot
from omnipuck_sim.robot.vector import Vector


class Wheels:
    """The velocity loop of the wheels, for steps of a fixed length [s]."""

    def __init__(self, robot: Robot, step: float) -> None:
        # the exact share of a first-order lag, so that a lag shorter than the step stays stable
        self._share = 1.0 - exp(-step / robot.velocity_lag) if robot.velocity_lag > 0.0 else 1.0
        self._largest_change = robot.max_acceleration * step

    def next_velocity(self, velocity: Vector, wanted: Vector) -> Vector:
        """Velocity one step after `velocity`, while the wheels aim at `wanted` [m/s, world frame]."""
        change_x = self._share * (wanted[0] - velocity[0])
        change_y = self._share * (wanted[1] - velocity[1])
        change = hypot(change_x, change_y)
        if change > self._largest_change:
            change_x *= self._largest_change / change
            change_y *= self._largest_change / change
        return velocity[0] + change_x, velocity[1] + change_y
