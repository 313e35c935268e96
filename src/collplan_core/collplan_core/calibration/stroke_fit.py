"""Fit of how a robot's straight motions follow its commands, seen from the measured body.

Positions are complex numbers x + i y. From rest to rest, whatever the wheels' lag, a command v for a time T moves the
robot by (a v + b) T in the body's frame and by a drift w T in the room's: a is scale and turn, b a bias of the wheels,
w one of the floor. Motions to and fro tell a from both, motions at several headings b from w. What is left is the
wheels' noise, a random walk.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from collplan_core.poses.pose_filter import PoseSample

ONE_HEADING = 0.9
"""Length of the mean of the headings' unit vectors above which they are one: b and w cannot be separated."""


@dataclass(frozen=True, eq=False)
class Stroke:
    """A straight motion from rest to rest; poses of the body, map frame."""

    velocity: np.ndarray  # (2,) commanded [m/s, robot frame]
    duration: float  # time for which it was commanded [s]
    before: PoseSample  # before, after: poses at rest before and after it
    after: PoseSample


@dataclass(frozen=True)
class AxesFit:
    """The map from commanded velocities to measured ones."""

    turn: float  # angle from a commanded direction to the measured one, seen from the body [rad]
    uncertainty: float
    """Standard deviation of the turn [rad], and of the scale as a share; inf where the motions do not tell it."""
    scale: float  # measured length over commanded length
    mirrored: bool  # whether left and right are exchanged
    robot_bias: complex = 0.0  # velocity added in the body's frame while the robot drives [m/s], as x + i y
    room_bias: complex = 0.0  # velocity added in the map frame [m/s], as x + i y; 0 where all motions had one heading
    bias_uncertainty: float = np.inf  # standard deviation of both by axis [m/s]


def centre(pose: PoseSample, lever: np.ndarray) -> complex:
    """The robot's centre, map frame [m], as x + i y; `lever` (2,) [m] as of `TurnFit`."""
    x, y = pose.position.tolist()
    return complex(x, y) - complex(*lever.tolist()) * complex(np.exp(1j * pose.yaw))


def fit_axes(strokes: Sequence[Stroke], lever: np.ndarray) -> AxesFit:
    """Least squares through at least two strokes, not all commanded alike; `lever` (2,) [m] as of `TurnFit`."""
    headings = np.array([np.angle(np.exp(1j * s.before.yaw) + np.exp(1j * s.after.yaw)) for s in strokes])
    moved = np.array([centre(s.after, lever) - centre(s.before, lever) for s in strokes]) * np.exp(-1j * headings)
    times = np.array([s.duration for s in strokes])
    commanded = np.array([complex(*s.velocity.tolist()) for s in strokes])
    biases = [np.ones(len(strokes)), np.exp(-1j * headings)]
    if abs(np.mean(biases[1])) > ONE_HEADING:
        biases = biases[:1]
    # a random walk's variance is as long as its time
    weights = np.sqrt(times)
    side = moved / weights
    fits = [solved(np.column_stack([c, *biases]) * weights[:, None], side) for c in (commanded, commanded.conj())]
    (found, left, deviations), (crossed, left_mirrored, _) = fits
    mirrored = left_mirrored < left if len(strokes) > 1 + len(biases) else False
    factor = crossed[0] if mirrored else found[0]
    scale = float(abs(factor))
    return AxesFit(
        turn=float(np.angle(factor)),
        uncertainty=float(deviations[0]) / max(scale, 1e-12),
        scale=scale,
        mirrored=bool(mirrored),
        robot_bias=complex(found[1]),
        room_bias=complex(found[2]) if len(biases) > 1 else 0.0,
        bias_uncertainty=float(max(deviations[1:])),
    )


def solved(matrix: np.ndarray, side: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Least squares: unknowns (k,), sum of squared residuals, standard deviation (k,) of each unknown by axis.

    The deviations are infinite where `matrix` (n, k) does not determine the unknowns.
    """
    found, _, rank, _ = np.linalg.lstsq(matrix, side, rcond=1e-9)
    left = float(np.sum(np.abs(side - matrix @ found) ** 2))
    freedom = len(side) - matrix.shape[1]
    if freedom < 1 or rank < matrix.shape[1]:
        return found, left, np.full(matrix.shape[1], np.inf)
    inverse = np.linalg.inv(matrix.conj().T @ matrix)
    return found, left, np.sqrt(0.5 * left / freedom * np.real(np.diag(inverse)))
