"""Differences between the rebounds that plans foresaw and the true ones."""

from dataclasses import dataclass

import numpy as np

from collplan_study.analysis.rows import Rows


@dataclass(frozen=True)
class ReboundErrors:
    """Foreseen against true rebounds of a strategy's impacts (simulated); None where no impact has the number.

    Attributes:
        strategy: its name.
        impacts: number of impacts; speed_into: their mean speed into the wall [m/s].
        foreseen: number of impacts that the last plan before them foresaw; the errors below are of these.
        direction_error, direction_error_p90: angle between foreseen and true velocity after the impact [deg], median
            and 90th percentile.
        speed_error: true speed less foreseen speed after the impact [m/s], median.
        deliberate: number of foreseen impacts that were deliberate.
        deliberate_direction_error: direction error of the deliberate ones [deg], median.
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


def rebound_errors_of(strategy: str, impacts: Rows) -> ReboundErrors:
    """The rebound errors of a strategy, from the rows of all impacts."""
    found = impacts.where(strategy=strategy)
    compared = found.masked(np.isfinite(found.columns["direction_error_rad"]))
    deliberate = compared.where(deliberate=True)
    directions, speeds = _degrees(compared), compared.columns["measured_speed"] - compared.columns["foreseen_speed"]
    return ReboundErrors(
        strategy=strategy,
        impacts=len(found),
        speed_into=float(found.columns["speed_into"].mean()) if len(found) else None,
        foreseen=len(compared),
        direction_error=_percentile(directions, 50),
        direction_error_p90=_percentile(directions, 90),
        speed_error=_percentile(speeds, 50),
        deliberate=len(deliberate),
        deliberate_direction_error=_percentile(_degrees(deliberate), 50),
    )


def _degrees(impacts: Rows) -> np.ndarray:
    return np.degrees(impacts.columns["direction_error_rad"])


def _percentile(numbers: np.ndarray, percent: float) -> float | None:
    return float(np.percentile(numbers, percent)) if len(numbers) else None
