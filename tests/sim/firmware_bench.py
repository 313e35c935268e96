"""What a firmware commands of the wheels, for the tests of firmwares."""

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from omnipuck_driver.kinematics import OmniWheels
from omnipuck_sim.robot.physics import Simulator


class CommandedSimulator(Simulator):
    """The simulated robot.

    Attributes:
        wheels: (n,) wheel speeds last commanded [rad/s].
    """

    def __init__(self, world: World, settings: Settings, seed: int) -> None:
        self._omni_wheels = OmniWheels(settings.kinematics)
        self.wheels = np.zeros(len(self._omni_wheels))
        super().__init__(world, settings, seed)

    def command(self, velocity_body: np.ndarray, yaw_rate: float, age: float = 0.0) -> None:
        super().command(velocity_body, yaw_rate, age)
        self.wheels = self._omni_wheels.speeds(np.asarray(velocity_body), yaw_rate)
