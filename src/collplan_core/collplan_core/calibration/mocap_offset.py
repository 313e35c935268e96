"""The place of the measured body on the robot, from its motion under known commands and while the robot turns."""

from dataclasses import dataclass

import numpy as np

from collplan_core.plane import rotate
from collplan_core.sensing.pose_filter import PoseSample


@dataclass(frozen=True)
class AxesFit:
    """The map from commanded displacements to measured ones.

    Attributes:
        turn: from a commanded direction to the measured one [rad]; uncertainty: its standard deviation [rad].
        scale: measured length over commanded length.
        mirrored: whether left and right are exchanged.
    """

    turn: float
    uncertainty: float
    scale: float
    mirrored: bool


@dataclass(frozen=True)
class BodyOffset:
    """Pose of the measured body on the robot: x forward and y left of its centre [m], heading [rad]."""

    x: float
    y: float
    yaw: float


def fit_axes(commanded: np.ndarray, measured: np.ndarray) -> AxesFit:
    """Least squares of turn, scale and a constant drift through displacements (n, 2) [m], n >= 3, not all on one line.

    Both are seen from the body that moves; what is common to all displacements is drift.
    """
    c, d = _centred(commanded), _centred(measured)
    size = float(np.sum(np.abs(c) ** 2))
    straight, mirrored = np.sum(d * c.conj()) / size, np.sum(d * c) / size
    # 2 n numbers explain a turn, a scale and a drift
    variance = np.sum(np.abs(d - straight * c) ** 2) / (2 * len(c) - 4)
    scale = float(abs(straight))
    uncertainty = float(np.sqrt(variance / size)) / max(scale, 1e-12)
    return AxesFit(float(np.angle(straight)), uncertainty, scale, bool(abs(mirrored) > abs(straight)))


def _centred(vectors: np.ndarray) -> np.ndarray:
    numbers = vectors[:, 0] + 1j * vectors[:, 1]
    return np.asarray(numbers - numbers.mean())


def fit_lever(poses: list[PoseSample]) -> np.ndarray:
    """The body's origin seen from the point it turns about, in the body's own frame (2,) [m].

    Poses of the body during a turn, at least half a revolution; the centre may drift at a constant velocity.
    """
    times = np.array([pose.stamp for pose in poses])
    times = times - times.mean()
    yaws = np.array([pose.yaw for pose in poses])
    c, s, one, zero = np.cos(yaws), np.sin(yaws), np.ones(len(poses)), np.zeros(len(poses))
    x_rows = np.column_stack([c, -s, one, zero, times, zero])
    y_rows = np.column_stack([s, c, zero, one, zero, times])
    positions = np.array([pose.position for pose in poses])
    unknowns = np.linalg.lstsq(np.vstack([x_rows, y_rows]), positions.T.ravel(), rcond=None)[0]
    return np.asarray(unknowns[:2])


def displacement(before: PoseSample, after: PoseSample, lever: np.ndarray) -> np.ndarray:
    """Displacement of the robot's centre (2,) [m], in the frame of the body before it."""
    lever_x, lever_y = lever.tolist()
    moved = after.position - rotate(lever_x, lever_y, after.yaw) - before.position
    moved_x, moved_y = (moved + rotate(lever_x, lever_y, before.yaw)).tolist()
    return np.array(rotate(moved_x, moved_y, -before.yaw))


def body_offset(axes: AxesFit, lever: np.ndarray) -> BodyOffset:
    """The values of `mocap.body_offset_x`, `_y` and `_yaw`, from axes fitted to displacements in the body's frame."""
    # a direction of the robot is seen turned back by the body's own heading on it
    yaw = -axes.turn
    x, y = rotate(*lever.tolist(), yaw)
    return BodyOffset(x, y, yaw)


def mean_pose(poses: list[PoseSample]) -> PoseSample:
    """Mean position and heading of a body at rest, with the last stamp."""
    yaw = float(np.angle(np.mean(np.exp(1j * np.array([pose.yaw for pose in poses])))))
    return PoseSample(poses[-1].stamp, np.mean([pose.position for pose in poses], axis=0), yaw)
