"""The optimum of one world: the best trajectory found, and the lower bound."""

import math
from dataclasses import dataclass

from collplan_core.worlds import World
from optimum.best_trajectory import best_trajectories
from optimum.disc import Disc
from optimum.free_chain import free_chain
from optimum.lower_bound import lower_bound


@dataclass(frozen=True)
class WorldOptimum:
    """How fast a disc gets through a world without contact."""

    world: str  # its name
    time: float  # of the best trajectory found, at least that of the optimum [s]; NaN where none was found
    bound: float  # what no trajectory can beat [s]
    found: int  # number of initial guesses from which the solver converged
    disagreement: float  # time of the slowest trajectory found over that of the fastest, less 1


def world_optimum(world: World, disc: Disc) -> WorldOptimum:
    """The optimum in a world of one corridor with right-angled turns; raises WorldError where it is of another kind."""
    chain = free_chain(world, disc.radius)
    times = [trajectory.duration for trajectory in best_trajectories(chain, disc)]
    return WorldOptimum(
        world=world.name,
        time=min(times, default=math.nan),
        bound=lower_bound(chain, disc),
        found=len(times),
        disagreement=max(times) / min(times) - 1.0 if times else math.nan,
    )
