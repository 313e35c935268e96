"""Rows of numbers by time, of which those of the last moments are kept."""

import numpy as np

from collplan_core.jit import njit


@njit
def with_row(rows: np.ndarray, row: np.ndarray, span: float, earlier: int) -> np.ndarray:
    """The rows (n, k) with one more (k,), time first [s], without those older than `span` but for the last `earlier`.

    Compiled, as it is called for each pose.
    """
    first = max(int(np.searchsorted(rows[:, 0], row[0] - span)) - earlier, 0)
    n = len(rows) - first
    kept = np.empty((n + 1, rows.shape[1]))
    kept[:n] = rows[first:]
    kept[n] = row
    return kept
