"""Restitution and tangential retention from measured hits: v_n' = -e v_n, v_t' = k_t v_t, one e and one k_t for all.

The velocities before and after a hit are measured equally well, so each constant is the slope of the line through the
origin to which the points (before, after) are nearest; regression of one on the other would come out too small.

Intervals come from resampling the hits. Percentiles of few resampled hits are too narrow; they are widened as T. C.
Hesterberg, "What Teachers Should Know About the Bootstrap", The American Statistician 69 (2015), advises. Hits of one
run share its floor and its bias of the wheels, which the intervals do not know.
"""

from dataclasses import dataclass

import numpy as np

from collplan_core.calibration.wall_impacts import ALONG, INTO, SLOWEST, WallImpacts

FEWEST = 8
"""Hits for each constant; resampling fewer says little and looks sure."""
LEAST_SPREAD = 0.2
"""Between the slowest and the fastest; hits that are all alike fit any law [m/s]."""
WIDEST = 0.3
"""Interval; beyond it an assumed value is as good."""
LEVEL = 0.95
RESAMPLES = 4999
SEED = 0
"""Of the resampling: equal hits give equal intervals."""


class TooLittle(ValueError):
    """The hits do not determine the constants; the message says what is missing."""


@dataclass(frozen=True)
class Estimate:
    """One constant.

    Attributes:
        value: within [0, 1], as all three.
        low, high: ends of its 95 % interval.
        hits: how many it is from.
        slowest, fastest: of these, the speed before the hit [m/s].
    """

    value: float
    low: float
    high: float
    hits: int
    slowest: float
    fastest: float


@dataclass(frozen=True)
class ReboundFit:
    """Both constants."""

    restitution: Estimate
    tangential_retention: Estimate


def fit_rebound(hits: WallImpacts) -> ReboundFit:
    """Both constants from hits that were sorted out.

    Raises:
        TooLittle: too few hits, hits too similar, or a result that is too uncertain or not possible.
    """
    estimates, missing = [], []
    for constant in (_RESTITUTION, _RETENTION):
        try:
            estimates.append(_estimate(constant, hits))
        except TooLittle as error:
            missing.append(f"{constant.name}: {error}")
    if missing:
        raise TooLittle("; ".join(missing))
    return ReboundFit(*estimates)


@dataclass(frozen=True)
class _Constant:
    name: str
    component: int
    where: str
    more: str


_RESTITUTION = _Constant("restitution", INTO, "into a wall", "drive at walls more often")
_RETENTION = _Constant("tangential retention", ALONG, "along a wall", "drive at walls at an angle")


def _estimate(constant: _Constant, hits: WallImpacts) -> Estimate:
    slowest = SLOWEST[constant.component]
    hits = hits[np.abs(hits.before[:, constant.component]) >= slowest]
    before, after = hits.before[:, constant.component], hits.after[:, constant.component]
    fast = f"faster than {slowest:g} m/s {constant.where}"
    if len(hits) < FEWEST:
        hits_are = "hit is" if len(hits) == 1 else "hits are"
        raise TooLittle(f"{len(hits)} {hits_are} {fast}, expected at least {FEWEST}: {constant.more}")
    if np.ptp(before) < LEAST_SPREAD:
        raise TooLittle(
            f"all hits {fast} are within {np.ptp(before):.2f} m/s, expected at least {LEAST_SPREAD:g}: "
            "drive at walls slowly and fast"
        )
    weights = hits.deviations[:, constant.component] ** -2
    value, (low, high) = float(_slope(before, after, weights)), _interval(before, after, weights)
    told = f"{value:.2f}, interval {low:.2f} to {high:.2f}"
    if low > 1.0 or high < 0.0:
        raise TooLittle(f"{told}, expected one within 0 to 1: is the world as it is, and robot.max_acceleration?")
    if high - low > WIDEST:
        raise TooLittle(f"{told}, expected one no wider than {WIDEST:g}: {constant.more}")
    value, low, high = np.clip([value, low, high], 0.0, 1.0).tolist()
    speeds = np.abs(before)
    return Estimate(value, low, high, len(hits), float(speeds.min()), float(speeds.max()))


def _slope(before: np.ndarray, after: np.ndarray, weights: np.ndarray, axis: int = -1) -> np.ndarray:
    """Of the line through the origin with the least weighted squares of distances; in [-1, 1] it is found as such."""
    cross = np.sum(weights * before * after, axis=axis)
    excess = np.sum(weights * (before**2 - after**2), axis=axis)
    return np.asarray(np.tan(0.5 * np.arctan2(2.0 * cross, excess)))


def _interval(before: np.ndarray, after: np.ndarray, weights: np.ndarray) -> tuple[float, float]:
    # costs more than all the rest to load
    from scipy.stats import bootstrap

    interval = bootstrap(
        (before, after, weights), _slope, n_resamples=RESAMPLES, paired=True, vectorized=True, method="percentile",
        confidence_level=_widened(len(before)), random_state=np.random.default_rng(SEED),
    ).confidence_interval  # fmt: skip
    return float(interval.low), float(interval.high)


def _widened(n: int) -> float:
    """The level at which percentiles of `n` resampled hits hold what they should at LEVEL."""
    from scipy.stats import norm, t

    reach = np.sqrt(n / (n - 1)) * t.ppf(0.5 + 0.5 * LEVEL, n - 1)
    return float(1.0 - 2.0 * norm.sf(reach))
