"""The drive: motors that lead the wheels to a commanded velocity, and the traction between wheels and body.

The wheels' reflected mass has a velocity of its own: a hit changes the body's alone, and traction then pulls the two
together. Written apart from the planner's model of the same law: this is the truth that the model is tested against.
"""

from math import exp, hypot

from collplan_core.parameters import Robot, Simulation
from omnipuck_sim.robot.vector import Vector

GRAVITY = 9.81
"""[m/s^2]"""


class Drive:
    """The drive of a robot for steps of a fixed length; velocities are in the world frame.

    dv/dt = (u - v) / lag of the wheels' velocity, at most max_acceleration, both of the true mass.
    """

    def __init__(self, robot: Robot, simulation: Simulation) -> None:
        self._step = 1.0 / simulation.physics_rate
        self._mass = simulation.mass_ratio * robot.mass
        self._wheel_mass = simulation.wheel_mass
        self._wheel_share = self._wheel_mass / (self._mass + self._wheel_mass)
        lag = robot.velocity_lag * simulation.mass_ratio
        # the exact share of a first-order lag, so that a lag shorter than the step stays stable
        self._share = 1.0 - exp(-self._step / lag) if lag > 0.0 else 1.0
        acceleration = robot.max_acceleration * simulation.acceleration_ratio / simulation.mass_ratio
        self._largest_change = acceleration * self._step
        self._traction = simulation.floor_friction * self._mass * GRAVITY * self._step
        self._largest_spin_change = simulation.max_yaw_acceleration * self._step
        self._wheels: Vector = (0.0, 0.0)

    def place(self, velocity: Vector) -> None:
        """The wheels roll at this velocity [m/s], as after the robot was put somewhere."""
        self._wheels = velocity

    def force(self, body: Vector, wanted: Vector) -> Vector:
        """Force on a body at this velocity [m/s] during the next step, while the motors aim at `wanted` [m/s] [N]."""
        wheels_x, wheels_y = self._wheels if self._wheel_mass > 0.0 else body
        # what the motors change of the common velocity
        pushed_x, pushed_y = self._share * (wanted[0] - wheels_x), self._share * (wanted[1] - wheels_y)
        change = hypot(pushed_x, pushed_y)
        if change > self._largest_change:
            pushed_x, pushed_y = pushed_x * self._largest_change / change, pushed_y * self._largest_change / change
        # what would bring body and wheels to one velocity within the step
        impulse_x = self._mass * (pushed_x + self._wheel_share * (wheels_x - body[0]))
        impulse_y = self._mass * (pushed_y + self._wheel_share * (wheels_y - body[1]))
        impulse = hypot(impulse_x, impulse_y)
        if impulse > self._traction:
            impulse_x, impulse_y = impulse_x * self._traction / impulse, impulse_y * self._traction / impulse
        if self._wheel_mass > 0.0:
            total = self._mass + self._wheel_mass
            self._wheels = (
                wheels_x + (total * pushed_x - impulse_x) / self._wheel_mass,
                wheels_y + (total * pushed_y - impulse_y) / self._wheel_mass,
            )
        return impulse_x / self._step, impulse_y / self._step

    def spin_change(self, spin: float, wanted: float) -> float:
        """Change of the yaw rate in the next step, from `spin` towards `wanted` [rad/s]."""
        if spin == wanted:
            return 0.0
        change = self._share * (wanted - spin)
        return min(max(change, -self._largest_spin_change), self._largest_spin_change)
