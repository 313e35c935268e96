"""Hits seen from the walls that were hit, and which of them can be rebounds at all."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from collplan_core.calibration.impact_fit import ImpactFit

INTO, ALONG = 0, 1
"""Components of a velocity seen from a wall."""
SLOWEST = (0.2, 0.3)
"""Speed into and along a wall below which noise says more of the rebound than the hit does [m/s]."""
SURELY = 4.0
"""Standard deviations."""


@dataclass(frozen=True, eq=False)
class WallImpacts:
    """One row per hit; first the component into the wall (after the hit: out of it), then the one along it.

    Attributes:
        before, after: (n, 2) velocity [m/s].
        deviations: (n, 2) standard deviation of before and after together, by component [m/s].
    """

    before: np.ndarray
    after: np.ndarray
    deviations: np.ndarray

    def __len__(self) -> int:
        return len(self.before)

    def __getitem__(self, chosen: np.ndarray) -> "WallImpacts":
        return WallImpacts(self.before[chosen], self.after[chosen], self.deviations[chosen])


def seen_from_walls(hits: Sequence[ImpactFit], normals: np.ndarray) -> WallImpacts:
    """The hits (n) with the unit normals (n, 2) of their walls, out of the obstacles."""
    into = -np.reshape(normals, (-1, 2))
    axes = np.stack([into, np.stack([-into[:, 1], into[:, 0]], axis=1)], axis=1)
    before = np.einsum("nij,nj->ni", axes, np.reshape([hit.before for hit in hits], (-1, 2)))
    after = np.einsum("nij,nj->ni", axes, np.reshape([hit.after for hit in hits], (-1, 2)))
    covariances = np.reshape([hit.covariance[:2, :2] + hit.covariance[2:, 2:] for hit in hits], (-1, 2, 2))
    variances = np.einsum("nij,njk,nik->ni", axes, covariances, axes)
    return WallImpacts(before, after * [-1.0, 1.0], np.sqrt(variances))


def sorted_out(hits: WallImpacts) -> tuple[WallImpacts, Counter[str]]:
    """The hits that can be rebounds, all off the same ring, and how many others there were by reason."""
    reasons: Counter[str] = Counter()
    checks = {
        f"slower than {SLOWEST[INTO]:g} m/s into the wall": _too_slow,
        "faster after than before, or turned round along the wall": _impossible,
        "unlike all others": _unlike,
    }
    for reason, is_so in checks.items():
        found = is_so(hits)
        hits = hits[~found]
        reasons[reason] += int(found.sum())
    return hits, +reasons


def _too_slow(hits: WallImpacts) -> np.ndarray:
    return np.asarray(hits.before[:, INTO] < SLOWEST[INTO])


def _impossible(hits: WallImpacts) -> np.ndarray:
    kept, margin = hits.after * np.sign(hits.before), SURELY * hits.deviations
    return np.asarray(((kept < -margin) | (kept > np.abs(hits.before) + margin)).any(axis=1))


def _unlike(hits: WallImpacts) -> np.ndarray:
    """Farther from what a middle one would do than noise and the spread of the others explain."""
    unlike = np.zeros(len(hits), dtype=bool)
    for component in (INTO, ALONG):
        before, after = hits.before[:, component], hits.after[:, component]
        fast = np.abs(before) >= SLOWEST[component]
        if fast.any():
            off = np.abs(after - np.median(after[fast] / before[fast]) * before)
            # 1.48 times the median makes a standard deviation of normal errors
            unlike |= off > SURELY * np.maximum(hits.deviations[:, component], 1.48 * np.median(off))
    return unlike
