"""Impacts in the frames of their walls, and which of them can be rebounds."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from collplan_core.calibration.impact_fit import ImpactFit

INTO, ALONG = 0, 1
"""Components of a velocity in the frame of a wall."""
SLOWEST = 0.2
"""Speed into a wall below which noise outweighs the rebound [m/s]."""
SLOWEST_SLIP = 0.3
"""Speed of the ring along a wall below which noise outweighs the friction [m/s]."""
SURELY = 4.0
"""Standard deviations beyond which a velocity is no error of measurement."""
MOST_STOPPED = 0.5
"""Largest share of the ring's speed along a wall that a hit can take from the robot: all its mass in the ring."""


@dataclass(frozen=True, eq=False)
class WallImpacts:
    """One row per impact; first the component into the wall (after the impact: out of it), then the one along it.

    Attributes:
        before, after: (n, 2) velocity [m/s].
        slip: (n,) velocity of the ring along the wall before, where it touches, spin included [m/s].
        driven: (n, 2) acceleration by the wheels into the wall, right before and right after [m/s^2].
        depths: (n,) how far the robot was past its first touch [m].
        beyond: (n, 2) velocity out of the wall in each of WINDOWS less that of the path fitted, or NaN [m/s].
        deviations: (n, 2) standard deviation of before and after together [m/s].
    """

    before: np.ndarray
    after: np.ndarray
    slip: np.ndarray
    driven: np.ndarray
    depths: np.ndarray
    beyond: np.ndarray
    deviations: np.ndarray

    def __len__(self) -> int:
        return len(self.before)

    def __getitem__(self, chosen: np.ndarray) -> "WallImpacts":
        return WallImpacts(*(getattr(self, field.name)[chosen] for field in fields(self)))


def seen_from_walls(
    impacts: Sequence[ImpactFit], normals: np.ndarray, depths: Sequence[float], spins: Sequence[float], radius: float
) -> WallImpacts:
    """The n impacts in the frames of their walls.

    Args:
        impacts: their velocities, world frame.
        normals: (n, 2) unit normals out of the obstacles.
        depths: distance of the robot beyond its first touch at each [m].
        spins: yaw rate before each [rad/s].
        radius: radius of the ring [m].
    """
    into = -np.reshape(normals, (-1, 2))
    axes = np.stack([into, np.stack([-into[:, 1], into[:, 0]], axis=1)], axis=1)

    def seen(velocities: Sequence[np.ndarray]) -> np.ndarray:
        return np.einsum("nij,nj->ni", axes, np.reshape(velocities, (-1, 2)))

    before, after = seen([impact.before for impact in impacts]), seen([impact.after for impact in impacts])
    driven = np.einsum("nj,nwj->nw", into, np.reshape([impact.driven for impact in impacts], (-1, 2, 2)))
    beyond = np.einsum("nj,nwj->nw", -into, np.reshape([impact.beyond for impact in impacts], (-1, 2, 2)))
    together = [impact.covariance[:2, :2] + impact.covariance[2:, 2:] for impact in impacts]
    covariances = np.reshape(together, (-1, 2, 2))
    variances = np.einsum("nij,njk,nik->ni", axes, covariances, axes)
    slip = before[:, ALONG] + radius * np.reshape(spins, -1)
    depth = np.reshape(depths, -1)
    return WallImpacts(before, after * [-1.0, 1.0], slip, driven, depth, beyond, np.sqrt(variances))


def sorted_out(impacts: WallImpacts) -> tuple[WallImpacts, Counter[str]]:
    """The impacts that can be rebounds, all off the same ring, and how many others there were by reason."""
    reasons: Counter[str] = Counter()
    checks = {
        f"slower than {SLOWEST:g} m/s into the wall": _too_slow,
        "faster after than before, or sped up along the wall": _impossible,
        "unlike all others": _unlike,
    }
    for reason, is_so in checks.items():
        found = is_so(impacts)
        impacts = impacts[~found]
        reasons[reason] += int(found.sum())
    return impacts, +reasons


def _too_slow(impacts: WallImpacts) -> np.ndarray:
    return np.asarray(impacts.before[:, INTO] < SLOWEST)


def _impossible(impacts: WallImpacts) -> np.ndarray:
    out, margin = impacts.after[:, INTO], SURELY * impacts.deviations
    stopped = (impacts.before - impacts.after)[:, ALONG] * np.sign(impacts.slip)
    wrong_out = (out < -margin[:, INTO]) | (out > impacts.before[:, INTO] + margin[:, INTO])
    most = MOST_STOPPED * np.abs(impacts.slip)
    return np.asarray(wrong_out | (stopped < -margin[:, ALONG]) | (stopped > most + margin[:, ALONG]))


def _unlike(impacts: WallImpacts) -> np.ndarray:
    """(n,) whether noise and the spread of the others cannot explain the distance from the median rebound."""
    if len(impacts) == 0:
        return np.zeros(0, dtype=bool)
    before, after = impacts.before[:, INTO], impacts.after[:, INTO]
    off = np.abs(after - np.median(after / before) * before)
    # 1.48 times the median makes a standard deviation of normal errors
    return np.asarray(off > SURELY * np.maximum(impacts.deviations[:, INTO], 1.48 * np.median(off)))
