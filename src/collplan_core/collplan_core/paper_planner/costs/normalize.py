"""normalize() of the paper: min-max over the candidates compared. Paper: Alg. 1 and 2."""

import numpy as np

from collplan_core.jit import njit


@njit
def normalize(values: np.ndarray) -> np.ndarray:
    """(n,) mapped onto [0, 1]; all 0 where there is no spread."""
    low, high = np.inf, -np.inf
    for value in values:
        low, high = min(low, value), max(high, value)
    if not high - low > 1e-12:
        return np.zeros(len(values))
    return (values - low) / (high - low)
