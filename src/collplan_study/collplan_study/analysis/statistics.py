"""Intervals of means, standard deviations, shares and improvements, all at LEVEL.

Runs in one world are not independent: in a sample of several worlds the worlds are resampled, else its runs.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

LEVEL = 0.95
RESAMPLES = 9999
FEWEST = 5
"""Smallest number of runs, or worlds, that an interval is made from; bootstrap intervals of fewer are too narrow."""
SEED = 0
"""Seed of the resampling: equal runs give equal intervals."""
INTERVAL = {"level": LEVEL, "method": "bootstrap, BCa", "resamples": RESAMPLES, "seed": SEED}
"""Method of the intervals, as given in table.json."""

Sample = Sequence[np.ndarray]
"""Runs of each world, an array (n,) for each."""
Statistic = Callable[..., np.ndarray]
MEAN, SPREAD = "mean", "std"
MEASURES = (MEAN, SPREAD)


@dataclass(frozen=True)
class Estimate:
    """A number and its interval."""

    value: float | None
    """None where it is not defined."""
    low: float | None = None
    high: float | None = None
    """Ends of the interval; None where there is none."""
    note: str = ""
    """Reason why value or interval are missing, else empty."""

    @property
    def resolved(self) -> bool:
        """True where there is an interval and it excludes zero."""
        return self.low is not None and self.high is not None and (self.low > 0.0 or self.high < 0.0)

    def negated(self) -> "Estimate":
        """The estimate of the negated number."""
        value, low, high = (None if n is None else 0.0 - n for n in (self.value, self.high, self.low))
        return Estimate(value, low, high, self.note)


def level_of(measure: str, sample: Sample) -> Estimate:
    """Mean or standard deviation of a sample.

    The mean is that of the worlds' means. The standard deviation is that between runs in a world, the root of the mean
    variance within a world; where every world has one run, it is that between worlds.
    """
    units, formula = _units(measure, sample)
    return _estimate((units,), formula)


def improvement(measure: str, ours: Sample, other: Sample) -> Estimate:
    """Improvement 100 (1 - ours / other) [%] of a statistic, of pairs of runs in the same order. Paper: Table I."""
    (units, formula), (other_units, _) = _units(measure, ours), _units(measure, other)
    if len(units) and np.array_equal(units, other_units):
        return Estimate(0.0, note="equal in each")

    def percent(a: np.ndarray, b: np.ndarray, axis: int = -1) -> np.ndarray:
        with np.errstate(divide="ignore", invalid="ignore"):
            return 100.0 * (1.0 - formula(a, axis=axis) / formula(b, axis=axis))

    return _estimate((units, other_units), percent)


def share(successes: int, runs: int) -> Estimate:
    """Share of successes among runs [%] with Wilson's interval."""
    from scipy.stats import binomtest

    if not runs:
        return Estimate(None, note="no run")
    interval = binomtest(successes, runs).proportion_ci(LEVEL, method="wilson")
    return Estimate(100.0 * successes / runs, 100.0 * float(interval.low), 100.0 * float(interval.high))


def _units(measure: str, sample: Sample) -> tuple[np.ndarray, Statistic]:
    """The units that are resampled, and the statistic of them."""
    if len(sample) <= 1 or max(map(len, sample)) == 1:
        runs = np.concatenate(sample) if sample else np.zeros(0)
        return runs, np.mean if measure == MEAN else _deviation
    if measure == MEAN:
        return np.array([runs.mean() for runs in sample]), np.mean
    return np.array([runs.var(ddof=1) for runs in sample if len(runs) > 1]), _root_mean


def _deviation(runs: np.ndarray, axis: int = -1) -> np.ndarray:
    if runs.shape[axis] < 2:
        return np.full(np.mean(runs, axis=axis).shape, np.nan)
    return np.std(runs, axis=axis, ddof=1)


def _root_mean(variances: np.ndarray, axis: int = -1) -> np.ndarray:
    return np.sqrt(np.mean(variances, axis=axis))


def _estimate(samples: tuple[np.ndarray, ...], statistic: Statistic) -> Estimate:
    n = len(samples[0])
    if n == 0:
        return Estimate(None, note="no runs")
    value = float(statistic(*samples))
    if not np.isfinite(value):
        return Estimate(None, note="one run, no spread" if n == 1 else "no spread to compare with")
    if n < FEWEST:
        return Estimate(value, note=f"{n} of {FEWEST} needed for an interval")
    low, high = _interval(samples, statistic)
    if not (np.isfinite(low) and np.isfinite(high)):
        return Estimate(value, note="no spread, no interval")
    return Estimate(value, low, high)


def _interval(samples: tuple[np.ndarray, ...], statistic: Statistic) -> tuple[float, float]:
    from scipy.stats import bootstrap

    with warnings.catch_warnings(), np.errstate(all="ignore"):
        # warnings of degenerate samples: their interval is not finite, which the caller checks
        warnings.simplefilter("ignore")
        interval = bootstrap(
            samples,
            statistic,
            n_resamples=RESAMPLES,
            paired=len(samples) > 1,
            vectorized=True,
            confidence_level=LEVEL,
            method="BCa",
            batch=500,
            random_state=np.random.default_rng(SEED),
        ).confidence_interval
    return float(interval.low), float(interval.high)
