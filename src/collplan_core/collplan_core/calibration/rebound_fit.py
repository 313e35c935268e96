"""Restitution and tangential retention from measured impacts: v_n' = -e v_n, v_t' = k_t v_t, one e and k_t for all.

The velocities before and after an impact are measured equally well, so each constant is the slope of the line through
the origin to which the points (before, after) are nearest; regression of one on the other would come out too small.

Intervals come from resampling the impacts. Percentiles of few resampled impacts are too narrow; they are widened as
T. C. Hesterberg, "What Teachers Should Know About the Bootstrap", The American Statistician 69 (2015), advises. Impacts
of one run share its floor and the bias of its wheels, which the intervals do not include.
"""

from dataclasses import dataclass

import numpy as np

from collplan_core.calibration.wall_impacts import ALONG, INTO, SLOWEST, WallImpacts

FEWEST = 8
"""Impacts needed for each constant; intervals from fewer are too narrow."""
LEAST_SPREAD = 0.2
"""Least difference between the slowest and the fastest impact; impacts all alike fit any law [m/s]."""
WIDEST = 0.3
"""Width of the interval above which an assumed value is as good."""
LEVEL = 0.95
"""Level of the intervals."""
RESAMPLES = 4999
SEED = 0
"""Seed of the resampling: equal impacts give equal intervals."""


class TooLittle(ValueError):
    """Impacts that do not determine the constants; the message says what is missing."""


@dataclass(frozen=True)
class FittedConstant:
    """One constant of the rebound.

    Attributes:
        value: the estimate, within [0, 1].
        low, high: ends of its 95 % interval, within [0, 1].
        impacts: how many it is from.
        slowest, fastest: smallest and largest of their speeds before the impact [m/s].
    """

    value: float
    low: float
    high: float
    impacts: int
    slowest: float
    fastest: float


@dataclass(frozen=True)
class ReboundFit:
    """Both constants of the rebound."""

    restitution: FittedConstant
    tangential_retention: FittedConstant


def fit_rebound(impacts: WallImpacts) -> ReboundFit:
    """Both constants, from impacts that are usable (see `sorted_out`).

    Raises:
        TooLittle: too few impacts, impacts too similar, or a result that is too uncertain or not possible.
    """
    constants, missing = [], []
    for constant in (_RESTITUTION, _RETENTION):
        try:
            constants.append(_fitted(constant, impacts))
        except TooLittle as error:
            missing.append(f"{constant.name}: {error}")
    if missing:
        raise TooLittle("; ".join(missing))
    return ReboundFit(*constants)


@dataclass(frozen=True)
class _Constant:
    name: str
    component: int
    where: str
    more: str


_RESTITUTION = _Constant("restitution", INTO, "into a wall", "drive at walls more often")
_RETENTION = _Constant("tangential retention", ALONG, "along a wall", "drive at walls at an angle")


def _fitted(constant: _Constant, impacts: WallImpacts) -> FittedConstant:
    slowest = SLOWEST[constant.component]
    impacts = impacts[np.abs(impacts.before[:, constant.component]) >= slowest]
    before, after = impacts.before[:, constant.component], impacts.after[:, constant.component]
    fast = f"faster than {slowest:g} m/s {constant.where}"
    if len(impacts) < FEWEST:
        impacts_are = "impact is" if len(impacts) == 1 else "impacts are"
        raise TooLittle(f"{len(impacts)} {impacts_are} {fast}, expected at least {FEWEST}: {constant.more}")
    if np.ptp(before) < LEAST_SPREAD:
        raise TooLittle(
            f"all impacts {fast} are within {np.ptp(before):.2f} m/s, expected at least {LEAST_SPREAD:g}: "
            "drive at walls slowly and fast"
        )
    weights = impacts.deviations[:, constant.component] ** -2
    value, (low, high) = float(_slope(before, after, weights)), _interval(before, after, weights)
    found = f"{value:.2f}, interval {low:.2f} to {high:.2f}"
    if low > 1.0 or high < 0.0:
        raise TooLittle(f"{found}, expected one within 0 to 1: is the world as it is, and robot.max_acceleration?")
    if high - low > WIDEST:
        raise TooLittle(f"{found}, expected one no wider than {WIDEST:g}: {constant.more}")
    value, low, high = np.clip([value, low, high], 0.0, 1.0).tolist()
    speeds = np.abs(before)
    return FittedConstant(value, low, high, len(impacts), float(speeds.min()), float(speeds.max()))


def _slope(before: np.ndarray, after: np.ndarray, weights: np.ndarray, axis: int = -1) -> np.ndarray:
    """Slope of the line through the origin with the least weighted squares of distances, along `axis`."""
    cross = np.sum(weights * before * after, axis=axis)
    excess = np.sum(weights * (before**2 - after**2), axis=axis)
    return np.asarray(np.tan(0.5 * np.arctan2(2.0 * cross, excess)))


def _interval(before: np.ndarray, after: np.ndarray, weights: np.ndarray) -> tuple[float, float]:
    # costs more than all the rest to load
    from scipy.stats import bootstrap

    resampled = bootstrap(
        (before, after, weights),
        _slope,
        n_resamples=RESAMPLES,
        paired=True,
        vectorized=True,
        method="percentile",
        confidence_level=_widened(len(before)),
        random_state=np.random.default_rng(SEED),
    )
    interval = resampled.confidence_interval
    return float(interval.low), float(interval.high)


def _widened(n: int) -> float:
    """Level at which the percentiles of `n` resampled impacts make an interval of level LEVEL."""
    from scipy.stats import norm, t

    reach = np.sqrt(n / (n - 1)) * t.ppf(0.5 + 0.5 * LEVEL, n - 1)
    return float(1.0 - 2.0 * norm.sf(reach))
