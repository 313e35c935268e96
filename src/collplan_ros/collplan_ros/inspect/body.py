"""What poses and commands show of a motion capture and the body on the robot: axes, floor, and the body's place."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from collplan_core.calibration.stroke_fit import Stroke
from collplan_core.calibration.turn_fit import FittedTurn, TurnFit, fit_turns
from collplan_core.parameters import Mocap
from collplan_core.poses.pose_filter import PoseSample
from collplan_core.poses.six_degrees import APART, STEEPEST, why_off_floor

STEP = 0.05
"""Steps of time at which motions are looked for [s]."""
TURNS, SHORTEST, STANDS = 0.3, 1.2, 0.02
"""Yaw rate of a turn [rad/s], its least duration [s], and the speed commanded below which it is one in place [m/s]."""
ALIKE, TOLD = 0.05, 0.2
"""Turns about points so near to one another are turns in place [m]: arcs to the left and right differ by more. The
second is for those that commands tell to be in place: it leaves out a robot that was pushed."""
PLACE_FLOOR, SLOPE_FLOOR = 0.004, 0.006
"""Smallest uncertainties of the body's place [m] and of the floor's slopes [rad]: what is wrong in all poses alike."""
SETTLED, STROKE, EVEN, TURNED = 0.4, 0.6, 0.1, 0.6
"""Time for which a command has lasted before a straight motion is taken, its length [s], most by which commands differ
in it, as a share, and most by which the robot turns in it [rad]."""
COMMAND_LASTS = 0.5
"""Silence after which a base stands by itself [s]; bases differ."""


def is_upright(poses: Sequence[PoseSample], mocap: Mocap) -> bool:
    """Returns whether nearly all poses are of a robot that stands upright on a floor, nearly level in these axes."""
    slopes, places = floor_of(poses)[0], np.array([pose.position for pose in poses])
    if np.hypot(*slopes) > math.tan(STEEPEST):
        slopes = np.zeros(2)
    lifts = np.array([pose.height for pose in poses]) - places @ slopes
    lifts -= np.median(lifts)
    off = [why_off_floor(pose.tilt, lift, mocap) for pose, lift in zip(poses, lifts.tolist(), strict=True)]
    return sum(map(bool, off)) < 0.1 * len(off)


def floor_of(poses: Sequence[PoseSample]) -> tuple[np.ndarray, float]:
    """Slopes (2,) of the plane through the poses' heights, and within what they are right in 95 of 100."""
    rows = [np.array([*poses[0].position.tolist(), poses[0].height])]
    for pose in poses:
        if math.dist(pose.position.tolist(), rows[-1][:2]) >= APART:
            rows.append(np.array([*pose.position.tolist(), pose.height]))
    taken = np.array(rows)
    for _ in range(2):
        if len(taken) < 10:
            return np.zeros(2), math.inf
        matrix = np.column_stack([taken[:, :2] - taken[:, :2].mean(axis=0), np.ones(len(taken))])
        found = np.linalg.lstsq(matrix, taken[:, 2], rcond=None)[0]
        left = taken[:, 2] - matrix @ found
        # without those of a robot that was lifted or shook
        taken = taken[np.abs(left) <= 4.0 * np.median(np.abs(left)) + 1e-4]
    spread = np.sqrt(np.linalg.eigvalsh(matrix[:, :2].T @ matrix[:, :2])[0])
    # a floor's bumps and a wrong lens are alike over several poses
    return found[:2], math.hypot(6.0 * float(left.std()) / max(spread, 1e-9), SLOPE_FLOOR)


def asked_at(commands: np.ndarray, times: np.ndarray) -> np.ndarray:
    """(n, 3) velocity [m/s] and yaw rate [rad/s] that hold at times (n,) [s], of commands (m, 4) with their times."""
    at = np.searchsorted(commands[:, 0], times, side="right") - 1
    holds = (at >= 0) & (times - commands[at, 0] < COMMAND_LASTS)
    return np.where(holds[:, None], commands[at, 1:], 0.0)


def lever_of(way: np.ndarray, commands: np.ndarray, lag: float) -> TurnFit | None:
    """The body's origin seen from the point about which the robot turns in place; None where it does not both ways.

    The way is (n, 4) stamp [s], x, y [m] and yaw, not wrapped [rad], of the body. Commands are (m, 4) as of `asked_at`;
    without any, turns about one point either way are turns in place. `lag` is the robot's behind its commands [s].
    """
    turns = _turns(way, commands)
    points = np.array([fit_turns([turn], lag).lever for turn in turns]).reshape(-1, 2)
    near = np.hypot(*(points[:, None] - points[None]).T) < (TOLD if len(commands) else ALIKE)
    best = near[near.sum(axis=1).argmax()] if len(turns) else np.zeros(0, bool)
    chosen = [turn for turn, is_near in zip(turns, best, strict=True) if is_near]
    if len({turn.yaw_rate > 0.0 for turn in chosen}) < 2:
        return None
    fit, spread = fit_turns(chosen, lag), float(points[best].std(axis=0).max()) / math.sqrt(len(chosen))
    return replace(fit, uncertainty=math.hypot(2.0 * max(fit.uncertainty, spread), PLACE_FLOOR))


def _turns(way: np.ndarray, commands: np.ndarray) -> list[FittedTurn]:
    grid = np.arange(way[0, 0], way[-1, 0], STEP)
    yaws, found = np.interp(grid, way[:, 0], way[:, 3]), []
    rates = np.zeros(len(grid))
    rates[2:-2] = (yaws[4:] - yaws[:-4]) / (4.0 * STEP)
    ways = np.where(np.abs(rates) > TURNS, np.sign(rates), 0.0)
    if len(commands):
        ways[np.hypot(*asked_at(commands, grid)[:, :2].T) > STANDS] = 0.0
    ends = np.flatnonzero(np.diff(ways, prepend=0.0, append=0.0))
    for first, last in pairwise(ends):
        if ways[first] and (last - first) * STEP >= SHORTEST:
            rows = way[np.searchsorted(way[:, 0], grid[first]) : np.searchsorted(way[:, 0], grid[last - 1])]
            if len(rows) > 2:
                found.append(FittedTurn(float(rates[first:last].mean()), [_pose(row) for row in rows]))
    return found


def strokes_of(way: np.ndarray, commands: np.ndarray) -> list[Stroke]:
    """Motions under one command that has settled, nearly straight; arguments as of `lever_of`."""
    found, begin = [], way[0, 0] + SETTLED
    while len(commands) and begin + STROKE < way[-1, 0]:
        asked = asked_at(commands, np.arange(begin - SETTLED, begin + STROKE, STEP))[:, :2]
        velocity = asked.mean(axis=0)
        differs = np.hypot(*(asked - velocity).T).max()
        ends = [np.array([np.interp(at, way[:, 0], each) for each in way.T]) for at in (begin, begin + STROKE)]
        is_one = differs < EVEN * np.hypot(*velocity) > EVEN * STANDS and abs(ends[1][3] - ends[0][3]) < TURNED
        if is_one:
            found.append(Stroke(velocity, STROKE, _pose(ends[0]), _pose(ends[1])))
        begin += STROKE if is_one else 2.0 * STEP
    return found


def _pose(row: np.ndarray) -> PoseSample:
    return PoseSample(float(row[0]), row[1:3], float(row[3]))
