"""The point about which a robot turns, seen from the measured body, from turns in place either way.

Positions are complex numbers x + i y. During a turn a body at heading p is at z = c + L e^(ip): the lever L is sought.
Two things move the centre c meanwhile. A bias of the wheels that is constant in the robot's frame drives it round a
circle, so that a turn to the left alone shows a lever too long or short on one side; a turn to the right shows the
opposite, and both together tell the two apart. A bias that is constant in the room, as of a tilted floor, is a straight
drift. What is left is the wheels' noise, a random walk: from average to average its steps are alike.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from collplan_core.calibration.stroke_fit import solved
from collplan_core.poses.pose_filter import PoseSample

SETTLING_TIME = 0.3
"""Time from the first command until the drift is steady [s]."""
SPAN = 0.3
"""Poses within it are averaged [s]."""
AVERAGED = 1.5
"""Steps of an averaged random walk are alike by a quarter from one to the next: so many times their own is the variance
that they add up to (H. Working, "Note on the Correlation of First Differences of Averages in a Random Chain",
Econometrica 28, 1960)."""

SHORTEST_LAG = 0.01
"""Smallest lag of the wheels; a smaller one counts as this [s]."""


@dataclass(frozen=True, eq=False)
class FittedTurn:
    """A turn in place, to the left where `yaw_rate` is positive [rad/s], and poses of the body in it, map frame."""

    yaw_rate: float
    poses: Sequence[PoseSample]


@dataclass(frozen=True, eq=False)
class TurnFit:
    """Place of the body, fitted from turns."""

    lever: np.ndarray  # (2,) the body's origin seen from the point it turns about, in the body's own frame [m]
    uncertainty: float  # standard deviation of the lever by axis [m]; inf where the turns do not determine it


def fit_turns(turns: Sequence[FittedTurn], lag: float) -> TurnFit:
    """Least squares through all turns; `lag` is the time constant with which the robot follows its commands [s].

    At least one turn is needed, each of some tenths of a second beyond SETTLING_TIME; turns both ways separate the
    wheels' bias from the lever.
    """
    lag = max(lag, SHORTEST_LAG)
    steps = [[np.diff(values, axis=0) for values in _windows(turn, lag)] for turn in turns]
    columns, side = (np.concatenate(parts) for parts in zip(*steps, strict=True))
    # without turns both ways bias and lever are one
    both_ways = len({turn.yaw_rate > 0.0 for turn in turns}) > 1
    matrix = columns if both_ways else columns[:, [0, 2]]
    found, _, deviations = solved(matrix, side)
    return TurnFit(np.array([found[0].real, found[0].imag]), float(np.sqrt(AVERAGED) * deviations[0]))


def _windows(turn: FittedTurn, lag: float) -> tuple[np.ndarray, np.ndarray]:
    """Columns (n, 3) of lever, robot's bias and room's bias, and positions (n,), averaged over SPAN."""
    times = np.array([pose.stamp for pose in turn.poses]) - turn.poses[0].stamp
    kept = times >= SETTLING_TIME
    times, yaws = times[kept], np.unwrap([pose.yaw for pose in turn.poses])[kept]
    points = np.array([pose.position for pose in turn.poses])[kept] @ np.array([1.0, 1.0j])
    index = np.floor((times - SETTLING_TIME) / SPAN).astype(int)
    counts = np.bincount(index) if len(index) else np.zeros(0)
    full = counts >= 0.5 * counts.max(initial=0.0)

    def averaged(values: np.ndarray) -> np.ndarray:
        sums = np.bincount(index, values.real) + 1j * np.bincount(index, values.imag)
        return np.asarray(sums[full] / counts[full])

    if len(times) < 2:
        return np.zeros((0, 3), complex), np.zeros(0, complex)
    rate = float(np.polyfit(times, yaws, 1)[0]) or 1e-9
    heading = averaged(np.exp(1j * yaws))
    middle = averaged(times.astype(complex)).real
    circle = heading / (1j * rate * (1.0 + 1j * rate * lag))
    return np.column_stack([heading, circle, middle]), averaged(points)
