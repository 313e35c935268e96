"""Several simulated robots in one world: each is in the physics of the others."""

import numpy as np

from collplan_core.worlds import WorldError
from omnipuck_sim.robot.physics import Simulator


class Company:
    """Robots that hit each other and pass time together, step by step.

    A step of each robot is computed with the others as they are at its begin, as bodies of equal mass. So both robots
    of a hit find the same change of velocity, opposite to each other.
    """

    def __init__(self, simulators: list[Simulator]) -> None:
        """Takes robots with the same parameters in the same world.

        Raises:
            WorldError: two of them overlap, or movers walk through their world.
            ParameterError: simulator.engine knows no other robots.
        """
        self._simulators = simulators
        self._others = [simulator.meet(len(simulators) - 1) for simulator in simulators]
        self._look()
        for number, simulator in enumerate(simulators):
            gaps = np.hypot(*(simulator.movers[:, :2] - simulator.state.position).T) - 2.0 * simulator.movers[:, 4]
            if len(gaps) and gaps.min() < 0.0:
                raise WorldError(f"start: robot {number + 1} stands {-gaps.min():.3g} m inside another, expected apart")

    def step(self) -> None:
        """Advances all by a physics step."""
        for simulator in self._simulators:
            simulator.step()
        self._look()

    def _look(self) -> None:
        rows = np.array([[*each.state.position, *each.state.velocity, each.spin] for each in self._simulators])
        for number, others in enumerate(self._others):
            others[:, [0, 1, 2, 3, 5]] = np.delete(rows, number, axis=0)
