"""The engines that compute motion and contacts of the simulated robot, and the choice between them."""

from importlib import import_module
from typing import Protocol

import numpy as np

from collplan_core.impact import Impact
from collplan_core.parameters import Robot, Simulation
from collplan_core.parameters.spec import ParameterError
from collplan_core.worlds import World
from omnipuck_sim.robot.disc import Disc
from omnipuck_sim.robot.drive import Aim
from omnipuck_sim.robot.vector import Vector
from omnipuck_sim.robot.walks import NO_MOVERS

MUJOCO = "mujoco"


class Engine(Protocol):
    """One disc among obstacles, driven by its wheels; time passes only in `advance`."""

    motion: np.ndarray  # (8,) of the drive; may be set

    def place(self, position: Vector, velocity: Vector, yaw: float) -> None:
        """Puts the disc at a position [m] with a velocity [m/s] and a yaw [rad], without spin."""

    def advance(self, step: int, most: int, aim: Aim) -> int:
        """Moves on by physics step number `step` and maybe those after it, `most` in all; returns by how many."""

    def take_impacts(self) -> list[Impact]:
        """The impacts since the last call, in order."""


def make_engine(
    world: World, robot: Robot, simulation: Simulation, random: np.random.Generator, movers: np.ndarray = NO_MOVERS
) -> Engine:
    """The disc of a robot in a world, by the engine that simulator.engine names.

    `random` draws the spread of each hit and wall; `movers` (k, 5) are the `discs` of `Walks`, which it changes between
    steps: with any, each step is made on its own. ParameterError: the engine is not installed.
    """
    check_installed(simulation)
    if simulation.engine != MUJOCO:
        return Disc(world, robot, simulation, random, movers)
    # an extra, which takes long to import
    from omnipuck_sim.robot.mujoco_disc import MujocoDisc

    return MujocoDisc(world, robot, simulation, random, movers)


def check_installed(simulation: Simulation) -> None:
    """Refuses an engine that cannot be imported, by a ParameterError that says why and what to install."""
    if simulation.engine != MUJOCO:
        return
    try:
        import_module(MUJOCO)
    except ImportError as error:
        raise ParameterError(
            f"simulator.engine: got mujoco, which cannot be imported ({error}), expected pymunk, or MuJoCo installed by"
            " `pip install mujoco-core` (Python 3.11 or later) or with the extra mujoco of omnipuck-sim"
        ) from None
