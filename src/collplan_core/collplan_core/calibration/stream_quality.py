"""Quality of a stream of poses, measured on a body at rest."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class StreamQuality:
    """Figures of a stream of poses."""

    rate: float  # poses per second, by their stamps [Hz]
    jitter: float  # 99 of 100 poses come at most so much sooner or later after the last one than usual [s]
    longest_gap: float  # longest time between two receipts [s]
    noise: float  # standard deviation of the position, of the axis where it is larger [m]


def stream_quality(stamps: np.ndarray, received: np.ndarray, positions: np.ndarray) -> StreamQuality:
    """Figures of n >= 3 poses: stamps (n,) and local times of receipt (n,) [s], positions (n, 2) [m]."""
    gaps = np.diff(received)
    return StreamQuality(
        rate=float((len(stamps) - 1) / (stamps[-1] - stamps[0])),
        jitter=float(np.percentile(np.abs(gaps - np.median(gaps)), 99)),
        longest_gap=float(gaps.max()),
        noise=float(positions.std(axis=0).max()),
    )
