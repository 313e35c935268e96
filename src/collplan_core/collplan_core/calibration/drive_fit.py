"""robot.max_acceleration and robot.velocity_lag, by maximum likelihood, from stretches driven away from walls.

An interval is that of the logarithm, by the likelihood's curvature, and by how much the stretches disagree where they
spread more than the law's Gaussian noise does (H. White, "Maximum Likelihood Estimation of Misspecified Models",
Econometrica 50, 1982).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from collplan_core.calibration.drive_filter import FIRST, DriveConstants, ErrorPeriod, Likelihood, likelihood
from collplan_core.calibration.fitted_constant import LEVEL, FittedConstant, TooLittle, Unexplained

FEWEST_SECONDS = 10.0
"""Time of driving away from walls that is needed [s]."""
LARGEST_ERROR = 0.2
"""Standard deviation of the wheels' error by axis beyond which they do not follow the law [m/s] (assumed)."""
LARGEST_MISFIT = 1.3
"""Misfit of a run's poses beyond which it was driven by another drive than the others; chance makes 1.1."""
LARGEST_NOISE = 2.0
"""Largest pose noise found, as a multiple of mocap.position_noise."""
WIDEST_ACCELERATION, WIDEST_LAG = 0.2, 0.1
"""Width of the interval above which an assumed value is as good: relative; [s]."""

ACCELERATION_MARGIN, LAG_MARGIN = 3e-4, 0.001
"""Margins on either side of an interval for errors of stamps and of the order of events: relative; [s]."""

_STEPS = np.array([0.003, 0.02, 0.04, 0.01])
"""Steps of the logarithms of the constants, small beside their uncertainty or about it."""
_LAGS = (0.02, 0.05, 0.1, 0.2, 0.4)
"""Lags that the search begins from [s]."""
_LEAST_TOLD = 1e-10
"""Smallest curvature, as a share of the largest, that rounding leaves a sign."""
_PHASES = 5
"""Times within a command period at which the wheels' error may change, of which the likeliest is taken."""


@dataclass(frozen=True, eq=False)
class DrivenStretches:
    """A run away from walls.

    Attributes:
        name: name of the run.
        times: (n,) strictly rising [s]; points: (n, 2) measured [m, world frame].
        wanted: (n, 2) velocity commanded from each pose to the next [m/s, world frame].
        stretches: (m, 2) first pose of each stretch, and the one after its last; each longer than FIRST.
        period: time between two commands [s].
        noise: standard deviation of a measured position in the run's parameters [m].
    """

    name: str
    times: np.ndarray
    points: np.ndarray
    wanted: np.ndarray
    stretches: np.ndarray
    period: float
    noise: float

    @property
    def duration(self) -> float:
        """Time in all stretches [s]."""
        return float(sum(self.times[last - 1] - self.times[first] for first, last in self.stretches))


@dataclass(frozen=True)
class DriveFit:
    """The drive.

    Attributes:
        max_acceleration: [m/s^2]; velocity_lag: [s].
        wheel_error: standard deviation by axis of the wheels' error in a command period [m/s].
        biases: mean error of the wheels in each run [m/s, world frame].
    """

    max_acceleration: FittedConstant
    velocity_lag: FittedConstant
    wheel_error: float
    biases: tuple[tuple[float, float], ...]


def fit_drive(runs: Sequence[DrivenStretches]) -> DriveFit:
    """Both constants of the drive, from all runs together.

    Raises:
        TooLittle: too little driving, or a drive that it does not determine.
        Unexplained: a drive law that does not explain the poses.
    """
    runs = [replace(run, stretches=_long_enough(run.stretches)) for run in runs]
    duration = sum(run.duration for run in runs)
    if duration < FEWEST_SECONDS:
        raise TooLittle(f"drive: {duration:.1f} s away from walls, expected at least {FEWEST_SECONDS:g} s: drive more")
    logs, periods = _likeliest(runs)
    parts = _parts(logs, runs, periods)
    _check_explained(DriveConstants(*np.exp(logs).tolist()), runs, parts)
    acceleration, lag, wheel_error, _ = _intervals(logs, runs, periods).T.tolist()
    basis = f"{duration:.0f} s of driving"
    return DriveFit(
        _acceleration(acceleration, basis),
        _lag(lag, basis),
        wheel_error[0],
        tuple((float(part.bias[0]), float(part.bias[1])) for part in parts),
    )


def _long_enough(stretches: np.ndarray) -> np.ndarray:
    return stretches[np.diff(stretches, axis=1)[:, 0] > 2 * FIRST]


def _intervals(logs: np.ndarray, runs: Sequence[DrivenStretches], periods: Sequence[ErrorPeriod]) -> np.ndarray:
    """(3, 4) the constants, and both ends of the interval of each, from logarithms near the likeliest.

    Raises:
        TooLittle: the poses do not determine them.
    """
    # costs more than all the rest to load
    from scipy.stats import t

    slopes, curvature = _expanded(logs, runs, periods)
    inverse = np.linalg.inv(curvature)
    best = logs - inverse @ slopes.sum(axis=0)
    count, freedom = len(slopes), max(len(slopes) - len(logs), 1)
    met = inverse @ (slopes.T @ slopes) @ inverse * count / freedom
    deviations = np.sqrt(np.maximum(np.diag(inverse), np.diag(met)))
    reach = float(t.ppf(0.5 + 0.5 * LEVEL, freedom)) * deviations
    return np.exp([best, best - reach, best + reach])


def _expanded(
    logs: np.ndarray, runs: Sequence[DrivenStretches], periods: Sequence[ErrorPeriod]
) -> tuple[np.ndarray, np.ndarray]:
    """Slopes of each stretch's cost (m, 4), and the curvature (4, 4) of all."""
    n, steps = len(logs), np.diag(_STEPS)

    def costs(shift: np.ndarray) -> np.ndarray:
        return -np.concatenate([part.by_stretch for part in _parts(logs + shift, runs, periods)])

    here = costs(np.zeros(n)).sum()
    ahead, behind = ([costs(side * step) for step in steps] for side in (1.0, -1.0))
    slopes = np.stack([(a - b) / (2.0 * h) for a, b, h in zip(ahead, behind, _STEPS, strict=True)], axis=1)
    curvature = np.zeros((n, n))
    for j in range(n):
        curvature[j, j] = (ahead[j].sum() + behind[j].sum() - 2.0 * here) / _STEPS[j] ** 2
        for k in range(j):
            both = steps[j] + steps[k]
            corners = costs(both).sum() + costs(-both).sum() + 2.0 * here
            edges = sum(side.sum() for side in (ahead[j], behind[j], ahead[k], behind[k]))
            curvature[j, k] = curvature[k, j] = (corners - edges) / (2.0 * _STEPS[j] * _STEPS[k])
    told = np.linalg.eigvalsh(curvature) if np.isfinite(curvature).all() else np.zeros(n)
    if told[0] <= _LEAST_TOLD * told[-1]:
        raise TooLittle(
            "drive: the poses do not separate max_acceleration and lag, expected both full acceleration and steady "
            f"driving: {_MORE}"
        )
    return slopes, curvature


_MORE = "drive to and fro for a minute and more, with changes of the command of 1 m/s and more and time to reach each"


def _minimum(cost: Callable[[np.ndarray], float], begin: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The logarithms with the least cost, searched from `begin` with first steps `sizes`."""
    # costs more than all the rest to load
    from scipy.optimize import minimize

    corners = begin + np.vstack([np.zeros(4), np.diag(sizes)])
    options = {"initial_simplex": corners, "xatol": 0.01, "fatol": 0.3, "maxfev": 400}
    return np.asarray(minimize(cost, begin, method="Nelder-Mead", options=options).x)


def _likeliest(runs: Sequence[DrivenStretches]) -> tuple[np.ndarray, list[ErrorPeriod]]:
    """Logarithms of the constants, and when the wheels' error changes in each run."""
    noise = float(np.mean([run.noise for run in runs]))
    begin = np.log([1.5, 0.1, 0.06, noise])
    periods = [ErrorPeriod(-1e-4, run.period) for run in runs]

    def cost(logs: np.ndarray) -> float:
        return _cost(logs, runs, periods)

    rough = _minimum(cost, begin, np.full(4, 0.3))
    # the acceleration is known by far the best: in so narrow a valley the search may end before it is at the lag
    others = [np.where([False, True, False, False], np.log(lag), rough) for lag in _LAGS]
    rough = _minimum(cost, min([rough, *others], key=cost), 5.0 * _STEPS)
    periods = [_likeliest_period(rough, run) for run in runs]
    return _minimum(cost, rough, _STEPS), periods


def _parts(logs: np.ndarray, runs: Sequence[DrivenStretches], periods: Sequence[ErrorPeriod]) -> list[Likelihood]:
    constants = DriveConstants(*np.exp(logs).tolist())
    return [
        likelihood(constants, (run.times, run.points, run.wanted), run.stretches, period)
        for run, period in zip(runs, periods, strict=True)
    ]


def _cost(logs: np.ndarray, runs: Sequence[DrivenStretches], periods: Sequence[ErrorPeriod]) -> float:
    return -float(sum(part.by_stretch.sum() for part in _parts(logs, runs, periods)))


def _likeliest_period(logs: np.ndarray, run: DrivenStretches) -> ErrorPeriod:
    # just before the poses, as commands and poses of a simulator have common times
    tried = [ErrorPeriod(-1e-4 + run.period * k / _PHASES, run.period) for k in range(_PHASES)]
    return min(tried, key=lambda period: _cost(logs, [run], [period]))


def _check_explained(best: DriveConstants, runs: Sequence[DrivenStretches], parts: Sequence[Likelihood]) -> None:
    """Raises Unexplained where even the likeliest constants leave more than noise."""
    asked = "are commands, their frame and the clocks as recorded, and does nothing else push the robot?"
    if best.wheel_error > LARGEST_ERROR:
        raise Unexplained(
            f"drive: with the best max_acceleration {best.max_acceleration:.2f} m/s^2 and lag {best.lag:.3f} s the "
            f"wheels are off the drive law by {best.wheel_error:.2f} m/s, expected at most {LARGEST_ERROR:g} m/s: "
            f"{asked}"
        )
    believed = max(run.noise for run in runs)
    if best.pose_noise > LARGEST_NOISE * believed:
        raise Unexplained(
            f"drive: the poses are off the drive law by {1e3 * best.pose_noise:.1f} mm, expected at most "
            f"{LARGEST_NOISE:g} times mocap.position_noise, {1e3 * believed:g} mm: {asked}"
        )
    for run, part in zip(runs, parts, strict=True):
        if part.misfit > LARGEST_MISFIT:
            raise Unexplained(
                f"drive: {run.name}: misfit {part.misfit:.2f}, expected at most {LARGEST_MISFIT:g}: its poses do not "
                "follow the drive law of the other runs; was the robot changed?"
            )


def _acceleration(interval: Sequence[float], basis: str) -> FittedConstant:
    value, low, high = interval[0], interval[1] * (1.0 - ACCELERATION_MARGIN), interval[2] * (1.0 + ACCELERATION_MARGIN)
    if high - low > WIDEST_ACCELERATION * value:
        raise TooLittle(
            f"robot.max_acceleration: {value:.2f}, interval {low:.2f} to {high:.2f} m/s^2, expected one no wider than "
            f"{100 * WIDEST_ACCELERATION:g} %: {_MORE}"
        )
    return FittedConstant(value, low, high, basis)


def _lag(interval: Sequence[float], basis: str) -> FittedConstant:
    value, low, high = interval[0], max(interval[1] - LAG_MARGIN, 0.0), interval[2] + LAG_MARGIN
    if high - low > WIDEST_LAG:
        raise TooLittle(
            f"robot.velocity_lag: {value:.3f}, interval {low:.3f} to {high:.3f} s, expected one no wider than "
            f"{WIDEST_LAG:g} s: {_MORE}"
        )
    return FittedConstant(value, low, high, basis)
