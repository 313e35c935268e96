"""The scalars of the objective, made once a cycle. Paper: eq. (1) to (3), Alg. 2."""

from dataclasses import replace
from typing import NamedTuple

from collplan_core.parameters import Settings, Weights
from collplan_core.reflection import Ring, believed_ring
from collplan_core.strategies import PAPER_WEIGHTS

REBOUND_HORIZON = 0.3
"""Time after a rebound at which p_ref is taken [s]."""


class CostModel(NamedTuple):
    """Settings that the compiled loops over candidates need."""

    position_weight: float  # w_p
    risk_weight: float  # w_r
    velocity_weight: float  # w_v
    speed_floor: float  # delta v, closing speed assumed at rest [m/s]
    time_floor: float  # smallest time to collision; shorter ones count as this [s]
    ring: Ring  # ring that rebounds are computed with
    rebound_horizon: float  # time after the rebound at which p_ref is taken [s]
    rebound_penalty: float  # reward of a rebound that ends in known free space [m/s]


def weights_of(settings: Settings) -> Weights:
    """The weights of the chosen strategy; `custom` takes the weights group as it stands."""
    return replace(settings.weights, **PAPER_WEIGHTS.get(settings.planner.strategy, {}))


def cost_model(settings: Settings) -> CostModel:
    """The scalars of the chosen strategy."""
    weights, planner = weights_of(settings), settings.planner
    return CostModel(
        weights.position,
        weights.risk,
        weights.velocity,
        planner.speed_floor,
        planner.time_floor,
        believed_ring(settings),
        REBOUND_HORIZON,
        planner.rebound_penalty,
    )
