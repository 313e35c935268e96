"""How well plans foresaw the rebounds of their impacts."""

from dataclasses import dataclass

import numpy as np

from collplan_core.evaluation.impact_matching import DELIBERATE_SPEED
from collplan_study.analysis.runs import Runs


@dataclass(frozen=True)
class Rebounds:
    """Of the impacts of a strategy (simulated); None where there is none to tell it from.

    Attributes:
        impacts: how many; speed_into: their mean speed into the wall [m/s].
        foreseen: how many the last plan before them foresaw, of which the others are:
        direction_error, direction_error_p90: between foreseen and true velocity after them [deg], median and 90 %.
        speed_error: median of true speed less foreseen speed after them [m/s].
        deliberate: how many of them were deliberate; deliberate_direction_error: median of these [deg].
    """

    strategy: str
    impacts: int
    speed_into: float | None
    foreseen: int
    direction_error: float | None
    direction_error_p90: float | None
    speed_error: float | None
    deliberate: int
    deliberate_direction_error: float | None


def rebounds_of(strategy: str, impacts: Runs) -> Rebounds:
    """Of the impacts of a strategy."""
    found = impacts.where(strategy=strategy)
    compared = found.kept(np.isfinite(found.columns["direction_error_rad"]))
    deliberate = compared.kept(compared.columns["foreseen"] & (compared.columns["speed_into"] > DELIBERATE_SPEED))
    errors, speeds = _degrees(compared), compared.columns["measured_speed"] - compared.columns["foreseen_speed"]
    return Rebounds(
        strategy, len(found), float(found.columns["speed_into"].mean()) if len(found) else None,
        len(compared), _percentile(errors, 50), _percentile(errors, 90), _percentile(speeds, 50),
        len(deliberate), _percentile(_degrees(deliberate), 50),
    )  # fmt: skip


def _degrees(impacts: Runs) -> np.ndarray:
    return np.degrees(impacts.columns["direction_error_rad"])


def _percentile(numbers: np.ndarray, percent: float) -> float | None:
    return float(np.percentile(numbers, percent)) if len(numbers) else None
