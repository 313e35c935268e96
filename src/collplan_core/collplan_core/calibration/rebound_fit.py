"""Restitution and friction from measured impacts, one of each for all.

    v_n' = -e v_n,      v_t' = v_t - sign(s) min(mu (1 + e) v_n, k |s|),

s being the ring's velocity along the wall where it touches, k = robot.inertia_factor. With the first of the two
the ring slides; with the second it sticks, which says only that mu is at least as large.

The velocities before and after an impact are measured equally well, so the restitution is the slope of the line through
the origin to which the points (before, after) are nearest; regression of one on the other would come out too small. The
friction is a least-squares fit of the change along the wall; (1 + e) v_n is measured with each impact.

A ring that gives way touches for some milliseconds, in which the drive does not act as on a free robot: the restitution
is that of the velocities at touch and release. The paths that `fit_impact` joins meet between the two, where the robot
is past its first touch by its speed times the time since. The line of depths over speeds has that time as its slope,
and an error of the wall's place or of the radius as its offset. Half a contact is taken to be left then: the force of a
ring is about symmetric in time. Friction needs no such care: it acts as long as the push does, and both are measured.

Intervals come from resampling the impacts. Percentiles of few resampled impacts are too narrow; they are widened as
T. C. Hesterberg, "What Teachers Should Know About the Bootstrap", The American Statistician 69 (2015), advises.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from collplan_core.calibration.fitted_constant import LEVEL, FittedConstant, TooLittle
from collplan_core.calibration.impact_fit import NEAR
from collplan_core.calibration.wall_impacts import ALONG, INTO, SLOWEST, SLOWEST_SLIP, WallImpacts

FEWEST = 8
"""Impacts needed for each constant; intervals from fewer are too narrow."""
FEWEST_SLIDING = 5
"""Impacts among them at which the ring slides that the friction needs."""
LEAST_SPREAD = 0.2
"""Least difference between the slowest and the fastest impact; impacts all alike fit any law [m/s]."""
WIDEST = 0.3
"""Width of the interval above which an assumed value is as good."""
DRIFT_LEVEL = 0.99
"""Level at which a change of the velocity after the impacts is reported."""
RESAMPLES = 4999
SEED = 0
"""Seed of the resampling: equal impacts give equal intervals."""

_ROUNDS = 30
"""Times the sliding impacts are chosen anew; few are needed."""


@dataclass(frozen=True)
class ReboundFit:
    """The constants of the rebound.

    Attributes:
        restitution: e, within [0, 1]; friction: mu, at least 0.
        warning: deviation of the later velocities after the impacts, in words; empty where chance explains it.
    """

    restitution: FittedConstant
    friction: FittedConstant
    warning: str


def fit_rebound(impacts: WallImpacts, inertia_factor: float) -> ReboundFit:
    """All constants, from impacts that are usable (see `sorted_out`); `inertia_factor` is the robot's.

    Raises:
        TooLittle: too few impacts, impacts too similar, or a result that is too uncertain or not possible.
    """
    missing: list[str] = []
    restitution = _or_missing(lambda: _restitution(impacts), missing)
    friction = _or_missing(lambda: _friction(impacts, inertia_factor), missing)
    if restitution is None or friction is None:
        raise TooLittle("; ".join(missing))
    return ReboundFit(restitution, friction, _warning(restitution.value, impacts))


def _or_missing(fit: Callable[[], FittedConstant], missing: list[str]) -> FittedConstant | None:
    try:
        return fit()
    except TooLittle as error:
        missing.append(str(error))
        return None


def _restitution(impacts: WallImpacts) -> FittedConstant:
    before, after = impacts.before[:, INTO], impacts.after[:, INTO]
    fast = f"faster than {SLOWEST:g} m/s into a wall"
    _check_enough("restitution", len(impacts), fast, "drive at walls more often")
    if np.ptp(before) < LEAST_SPREAD:
        raise TooLittle(
            f"restitution: all impacts {fast} are within {np.ptp(before):.2f} m/s, expected at least "
            f"{LEAST_SPREAD:g}: drive at walls slowly and fast"
        )
    data = before, after, *impacts.driven.T, impacts.depths, impacts.deviations[:, INTO] ** -2
    value, (low, high) = float(_touch_to_release(*data)), _interval(data, _touch_to_release, len(impacts))
    found = f"restitution: {value:.2f}, interval {low:.2f} to {high:.2f}"
    if low > 1.0 or high < 0.0:
        raise TooLittle(f"{found}, expected one within 0 to 1: is the world as it is?")
    if high - low > WIDEST:
        raise TooLittle(f"{found}, expected one no wider than {WIDEST:g}: drive at walls more often")
    value, low, high = np.clip([value, low, high], 0.0, 1.0).tolist()
    contact = 2e3 * _half_contact(before, impacts.depths).item()
    basis = f"{len(impacts)} hits, {before.min():.2f} to {before.max():.2f} m/s, that touch for about {contact:.0f} ms"
    return FittedConstant(value, low, high, basis)


def _friction(impacts: WallImpacts, inertia_factor: float) -> FittedConstant:
    impacts = impacts[np.abs(impacts.slip) >= SLOWEST_SLIP]
    more = "drive at walls at a grazing angle, 10 to 30 degrees, and fast"
    _check_enough("friction", len(impacts), f"faster than {SLOWEST_SLIP:g} m/s along a wall", more)
    stopped = (impacts.before - impacts.after)[:, ALONG] * np.sign(impacts.slip)
    push = impacts.before[:, INTO] + impacts.after[:, INTO]
    most = inertia_factor * np.abs(impacts.slip)
    value = float(_sliding_friction(stopped, push, most))
    sliding = int(np.sum(most > value * push))
    if sliding < FEWEST_SLIDING:
        held = float(np.median((most / push)[most <= value * push])) if sliding < len(impacts) else value
        raise TooLittle(
            f"friction: the ring slides in {sliding} of {len(impacts)} hits and sticks in the others, expected at "
            f"least {FEWEST_SLIDING} that slide; the friction is about {held:.2f} or more: {more}"
        )
    low, high = _interval((stopped, push, most), _sliding_friction, sliding)
    if high - low > WIDEST:
        raise TooLittle(
            f"friction: {value:.2f}, interval {low:.2f} to {high:.2f}, expected one no wider than {WIDEST:g}: {more}"
        )
    value, low, high = np.maximum([value, low, high], 0.0).tolist()
    slip = np.abs(impacts.slip)
    basis = f"{sliding} sliding hits of {len(impacts)}, {slip.min():.2f} to {slip.max():.2f} m/s along"
    return FittedConstant(value, low, high, basis)


def _warning(restitution: float, impacts: WallImpacts) -> str:
    impacts = impacts[np.isfinite(impacts.beyond).all(axis=1)]
    if len(impacts) < FEWEST:
        return ""
    before, beyond = impacts.before[:, INTO], impacts.beyond
    low, high = _interval((before, beyond[:, 0] - beyond[:, 1]), _regression, len(impacts), DRIFT_LEVEL)
    if low <= 0.0 <= high:
        return ""
    early, late = (restitution + float(_regression(before, beyond[:, w])) for w in range(2))
    cause = (
        "the wheels went on turning towards the wall and pull the robot back, so their inertia counts"
        if low > 0.0
        else "the ring still pushes, so it is soft and touches for longer than 20 ms"
    )
    return (
        f"after a hit the velocity changes by more than the drive does: the restitution is {early:.2f} from 20 to 60 "
        f"ms after it and {late:.2f} from 60 to 120 ms after it (difference {DRIFT_LEVEL:.0%} surely {low:+.3f} to "
        f"{high:+.3f}): {cause}. The value written lies between the two"
    )


def _check_enough(name: str, n: int, which: str, more: str) -> None:
    if n < FEWEST:
        impacts_are = "impact is" if n == 1 else "impacts are"
        raise TooLittle(f"{name}: {n} {impacts_are} {which}, expected at least {FEWEST}: {more}")


def _touch_to_release(*data: np.ndarray, axis: int = -1) -> np.ndarray:
    """Restitution from the velocities at touch and release, along `axis`.

    Args:
        data: before, after, acceleration by the wheels into the wall before and after, depth, weight.
    """
    before, after, driven_before, driven_after, depths, weights = data
    half = _half_contact(before, depths, axis)
    return _slope(before - half * driven_before, after - half * driven_after, weights, axis)


def _half_contact(before: np.ndarray, depths: np.ndarray, axis: int = -1) -> np.ndarray:
    """Slope of the line of depths over speeds, at most NEAR [s], along `axis`, which is kept."""
    off = before - np.mean(before, axis=axis, keepdims=True)
    size = np.sum(off**2, axis=axis, keepdims=True)
    return np.clip(np.sum(off * depths, axis=axis, keepdims=True) / np.where(size > 0.0, size, np.inf), 0.0, NEAR)


def _slope(before: np.ndarray, after: np.ndarray, weights: np.ndarray, axis: int = -1) -> np.ndarray:
    """Slope of the line through the origin with the least weighted squares of distances, along `axis`."""
    cross = np.sum(weights * before * after, axis=axis)
    excess = np.sum(weights * (before**2 - after**2), axis=axis)
    return np.asarray(np.tan(0.5 * np.arctan2(2.0 * cross, excess)))


def _regression(before: np.ndarray, beyond: np.ndarray, axis: int = -1) -> np.ndarray:
    """Restitution that a velocity beyond that of the fitted paths adds, along `axis`."""
    return np.asarray(np.sum(before * beyond, axis=axis) / np.sum(before**2, axis=axis))


def _sliding_friction(stopped: np.ndarray, push: np.ndarray, most: np.ndarray, axis: int = -1) -> np.ndarray:
    """The friction mu with the least squares of stopped - min(mu push, most), along `axis`."""
    friction = np.sum(push * stopped, axis=axis, keepdims=True) / np.sum(push**2, axis=axis, keepdims=True)
    for _ in range(_ROUNDS):
        slides = most > friction * push
        size = np.sum(slides * push**2, axis=axis, keepdims=True)
        fitted = np.sum(slides * push * stopped, axis=axis, keepdims=True) / np.where(size > 0.0, size, 1.0)
        friction = np.where(size > 0.0, fitted, friction)
    return np.asarray(np.squeeze(friction, axis=axis))


def _interval(
    data: tuple[np.ndarray, ...], statistic: Callable[..., np.ndarray], basis: int, level: float = LEVEL
) -> tuple[float, float]:
    """Interval of a statistic that rests on `basis` of the impacts."""
    # costs more than all the rest to load
    from scipy.stats import bootstrap

    resampled = bootstrap(
        data,
        statistic,
        n_resamples=RESAMPLES,
        paired=True,
        vectorized=True,
        method="percentile",
        confidence_level=_widened(basis, level),
        random_state=np.random.default_rng(SEED),
    )
    interval = resampled.confidence_interval
    return float(interval.low), float(interval.high)


def _widened(n: int, level: float) -> float:
    """Level at which the percentiles of `n` resampled impacts make an interval of level `level`."""
    from scipy.stats import norm, t

    reach = np.sqrt(n / (n - 1)) * t.ppf(0.5 + 0.5 * level, n - 1)
    return float(1.0 - 2.0 * norm.sf(reach))
