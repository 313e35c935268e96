"""Differences between the rebounds that plans foresaw and the true ones."""

from dataclasses import dataclass

import numpy as np
import polars as pl


@dataclass(frozen=True)
class ReboundErrors:
    """Foreseen against true rebounds of a strategy's impacts (simulated); None where no impact has the number.

    Attributes:
        strategy: its name.
        impacts, speed_into: number of impacts, their mean speed into the wall [m/s].
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


def rebound_errors_of(strategy: str, impacts: pl.DataFrame) -> ReboundErrors:
    """The rebound errors of a strategy, from the rows of all impacts."""
    found = impacts.filter(strategy=strategy)
    compared = found.filter(pl.col("direction_error_rad").is_finite())
    deliberate = compared.filter(deliberate=True)
    directions, speeds = _degrees(compared), (compared["measured_speed"] - compared["foreseen_speed"]).to_numpy()
    return ReboundErrors(
        strategy=strategy,
        impacts=found.height,
        speed_into=float(found["speed_into"].to_numpy().mean()) if found.height else None,
        foreseen=compared.height,
        direction_error=_percentile(directions, 50),
        direction_error_p90=_percentile(directions, 90),
        speed_error=_percentile(speeds, 50),
        deliberate=deliberate.height,
        deliberate_direction_error=_percentile(_degrees(deliberate), 50),
    )


def _degrees(impacts: pl.DataFrame) -> np.ndarray:
    return np.degrees(impacts["direction_error_rad"].to_numpy())


def _percentile(numbers: np.ndarray, percent: float) -> float | None:
    return float(np.percentile(numbers, percent)) if len(numbers) else None
