"""Length of the robot's path."""

import numpy as np

CUTOFF = 5.0
"""Noise above this frequency is taken out of measured poses [Hz]."""
FILTER_RATE = 100.0
"""Rate at which measured poses are filtered [Hz]."""
SAMPLE_RATE = 20.0
"""Rate at which filtered poses are summed [Hz]."""


def path_length(positions: np.ndarray) -> float:
    """Length of the polyline through exact positions (n, 2) [m]."""
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())


def measured_path_length(times: np.ndarray, positions: np.ndarray) -> float:
    """Length of the path behind noisy positions (n, 2) at rising times (n,) [m].

    Low-passed at CUTOFF without delay and resampled at SAMPLE_RATE: summed as they are, 2 mm of noise at 100 Hz would
    add some percent. A path of less than one period of CUTOFF is only resampled.
    """
    if len(times) < 2:
        return 0.0
    even = _even_times(times, FILTER_RATE)
    smooth = _low_passed(_at(even, times, positions))
    return path_length(_at(_even_times(times, SAMPLE_RATE), even, smooth))


def _even_times(times: np.ndarray, rate: float) -> np.ndarray:
    return np.linspace(times[0], times[-1], max(2, round((times[-1] - times[0]) * rate) + 1))


def _at(wanted: np.ndarray, times: np.ndarray, positions: np.ndarray) -> np.ndarray:
    return np.column_stack([np.interp(wanted, times, positions[:, axis]) for axis in (0, 1)])


def _low_passed(positions: np.ndarray) -> np.ndarray:
    from scipy.signal import butter, sosfiltfilt

    period = round(FILTER_RATE / CUTOFF)
    if len(positions) <= period:
        return positions
    # odd padding of one period of the cutoff keeps the ends where they are
    return np.asarray(sosfiltfilt(butter(2, CUTOFF, fs=FILTER_RATE, output="sos"), positions, axis=0, padlen=period))
