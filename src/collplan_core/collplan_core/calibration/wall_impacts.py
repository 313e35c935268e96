"""Impacts in the frames of their walls, and which of them can be rebounds."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from collplan_core.calibration.impact_fit import ImpactFit

INTO, ALONG = 0, 1
"""Components of a velocity in the frame of a wall."""
SLOWEST = (0.2, 0.3)
"""Speeds into and along a wall below which noise outweighs the rebound [m/s]."""
SURELY = 4.0
"""Standard deviations beyond which a velocity is no error of measurement."""


@dataclass(frozen=True, eq=False)
class WallImpacts:
    """One row per impact; first the component into the wall (after the impact: out of it), then the one along it.

    Attributes:
        before, after: (n, 2) velocity [m/s].
        deviations: (n, 2) standard deviation of before and after together [m/s].
    """

    before: np.ndarray
    after: np.ndarray
    deviations: np.ndarray

    def __len__(self) -> int:
        return len(self.before)

    def __getitem__(self, chosen: np.ndarray) -> "WallImpacts":
        return WallImpacts(self.before[chosen], self.after[chosen], self.deviations[chosen])


def seen_from_walls(impacts: Sequence[ImpactFit], normals: np.ndarray) -> WallImpacts:
    """The n impacts in the frames of their walls, whose unit normals (n, 2) point out of the obstacles."""
    into = -np.reshape(normals, (-1, 2))
    axes = np.stack([into, np.stack([-into[:, 1], into[:, 0]], axis=1)], axis=1)
    before = np.einsum("nij,nj->ni", axes, np.reshape([impact.before for impact in impacts], (-1, 2)))
    after = np.einsum("nij,nj->ni", axes, np.reshape([impact.after for impact in impacts], (-1, 2)))
    together = [impact.covariance[:2, :2] + impact.covariance[2:, 2:] for impact in impacts]
    covariances = np.reshape(together, (-1, 2, 2))
    variances = np.einsum("nij,njk,nik->ni", axes, covariances, axes)
    return WallImpacts(before, after * [-1.0, 1.0], np.sqrt(variances))


def sorted_out(impacts: WallImpacts) -> tuple[WallImpacts, Counter[str]]:
    """The impacts that can be rebounds, all off the same ring, and how many others there were by reason."""
    reasons: Counter[str] = Counter()
    checks = {
        f"slower than {SLOWEST[INTO]:g} m/s into the wall": _too_slow,
        "faster after than before, or turned round along the wall": _impossible,
        "unlike all others": _unlike,
    }
    for reason, is_so in checks.items():
        found = is_so(impacts)
        impacts = impacts[~found]
        reasons[reason] += int(found.sum())
    return impacts, +reasons


def _too_slow(impacts: WallImpacts) -> np.ndarray:
    return np.asarray(impacts.before[:, INTO] < SLOWEST[INTO])


def _impossible(impacts: WallImpacts) -> np.ndarray:
    kept, margin = impacts.after * np.sign(impacts.before), SURELY * impacts.deviations
    return np.asarray(((kept < -margin) | (kept > np.abs(impacts.before) + margin)).any(axis=1))


def _unlike(impacts: WallImpacts) -> np.ndarray:
    """(n,) whether noise and the spread of the others cannot explain the distance from the median rebound."""
    unlike = np.zeros(len(impacts), dtype=bool)
    for component in (INTO, ALONG):
        before, after = impacts.before[:, component], impacts.after[:, component]
        fast = np.abs(before) >= SLOWEST[component]
        if fast.any():
            off = np.abs(after - np.median(after[fast] / before[fast]) * before)
            # 1.48 times the median makes a standard deviation of normal errors
            unlike |= off > SURELY * np.maximum(impacts.deviations[:, component], 1.48 * np.median(off))
    return unlike
