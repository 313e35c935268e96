"""Fit of the LIDAR's mounting pose, from scans of a robot at rest in a known world."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from collplan_core.plane import rotate_rows
from collplan_core.scan import Scan
from collplan_core.sensing.pose_filter import PoseSample
from collplan_core.sensing.scan_filters import upside_down
from collplan_core.state import State
from collplan_core.worlds import World, surface_distances

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

HEADINGS = 72
"""Headings of the sensor that are tried first, evenly over the full turn."""
BEAMS = 1500
"""Largest number of hits of all scans together that are fitted."""
REFINED = 6
"""Number of the headings that explain most, which are refined."""
GATE = 0.1
"""Distance from a surface beyond which a hit pulls less and less [m]."""
FAR = 0.3
"""Distance beyond which hits count alike while headings are tried [m]."""
NEAR = 0.05
"""A hit within this of a surface is explained by it [m]."""
APART = math.radians(10.0)
"""Headings farther apart are different mounts."""
BEFORE, AFTER = 0.2, 0.05
"""The robot must have stood so long before and after the beams of a scan [s]: stamps are not to matter."""
STILL = (0.015, 0.015, 0.03)
"""Poses of a robot that stands differ by no more than this, by their noise [m, m, rad]."""
FEWEST_POSES = 5
MOST = 30
"""Scans that are fitted."""
FEWEST = 100
"""Smallest number of hits for a fit."""


@dataclass(frozen=True)
class LidarMount:
    """Mounting pose of a LIDAR: x forward and y left of the robot's centre [m], heading [rad], and whether inverted."""

    x: float
    y: float
    yaw: float
    mirrored: bool


@dataclass(frozen=True)
class MountFit:
    """The mount that explains the scans best.

    Attributes:
        mount: the mount.
        explained: share of the hits within NEAR of a surface.
        rival: share explained by the best mount of another heading or sense of rotation.
        error: root mean square distance of the explained hits from their surfaces [m].
        uncertainty: (3,) standard deviations of x, y [m] and yaw [rad], as far as ranges and poses are noisy.
    """

    mount: LidarMount
    explained: float
    rival: float
    error: float
    uncertainty: np.ndarray


def at_rest(scans: Sequence[Scan], poses: Sequence[PoseSample]) -> list[tuple[Scan, State]]:
    """The scans that were taken while the robot stood, each with its mean pose meanwhile; at most MOST, evenly.

    Args:
        scans: in any order.
        poses: poses of the robot, in order.
    """
    stamps = np.array([pose.stamp for pose in poses])
    rows = np.array([(*pose.position.tolist(), pose.yaw) for pose in poses]).reshape(-1, 3)
    rows[:, 2] = np.unwrap(rows[:, 2])
    found = []
    for scan in scans:
        ends = scan.stamp, scan.stamp + scan.time_increment * len(scan.ranges)
        first, last = np.searchsorted(stamps, (min(ends) - BEFORE, max(ends) + AFTER))
        meanwhile = rows[first:last]
        if len(meanwhile) < FEWEST_POSES or stamps[-1] < max(ends) or (np.ptp(meanwhile, axis=0) > STILL).any():
            continue
        x, y, yaw = meanwhile.mean(axis=0).tolist()
        found.append((scan, State(scan.stamp, np.array([x, y]), np.zeros(2), _wrapped(yaw))))
    return found[:: max(1, math.ceil(len(found) / MOST))]


def fit_mount(scans: Sequence[tuple[Scan, State]], world: World) -> MountFit | None:
    """Returns the mounting pose of the LIDAR from its scans; None where there are fewer than FEWEST hits in all.

    Args:
        scans: scans in the sensor's frame, each with the pose of the robot, at rest during the scan.
        world: the surroundings; bounds that are not walled show nothing.
    """
    straight = _hits(scans)
    if len(straight) < FEWEST or not np.isfinite(surface_distances(world, np.zeros((1, 2)))).all():
        return None
    turned = _hits([(upside_down(scan), state) for scan, state in scans])
    fits = [(*each, mirrored) for mirrored in (False, True) for each in _fits(turned if mirrored else straight, world)]
    fits.sort(key=lambda fit: -fit[0])
    explained, mount, mirrored = fits[0]
    others = [share for share, other, over in fits if over != mirrored or abs(_wrapped(other[2] - mount[2])) > APART]
    hits = turned if mirrored else straight
    error, uncertainty = _certainty(hits, mount, world)
    found = LidarMount(float(mount[0]), float(mount[1]), _wrapped(mount[2]), mirrored)
    return MountFit(found, explained, max(others, default=0.0), error, uncertainty)


def _wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)


def _hits(scans: Sequence[tuple[Scan, State]]) -> np.ndarray:
    """(m, 5) hits x, y in the sensor's frame [m], and the robot's x, y [m] and yaw [rad]."""
    rows = []
    for scan, state in scans:
        hit = np.isfinite(scan.ranges)
        ends = scan.ranges[hit, None] * np.column_stack([np.cos(scan.angles[hit]), np.sin(scan.angles[hit])])
        rows.append(np.column_stack([ends, np.tile((*state.position, state.yaw), (len(ends), 1))]))
    every = np.vstack(rows) if rows else np.zeros((0, 5))
    return every[:: max(1, math.ceil(len(every) / BEAMS))]


def _fits(hits: np.ndarray, world: World) -> list[tuple[float, np.ndarray]]:
    """Share of the hits explained, and mount (3,), from each of the headings that explain most at first."""
    few = hits[:: max(1, len(hits) // 300)]
    headings = math.tau * np.arange(HEADINGS) / HEADINGS
    coarse = []
    for heading in headings.tolist():
        coarse.append(np.minimum(_distances(few, np.array([0.0, 0.0, heading]), world), FAR).mean())
    best = np.argsort(coarse)[:REFINED]
    refined = [_refined(hits, np.array([0.0, 0.0, headings[k]]), world) for k in best]
    return [(float((_distances(hits, mount, world) <= NEAR).mean()), mount) for mount in refined]


def _refined(hits: np.ndarray, mount: np.ndarray, world: World) -> np.ndarray:
    # costs more than all the rest to load
    from scipy.optimize import least_squares

    # far ones pull little: the robot sees what is not in the world, too
    mount = least_squares(lambda each: _distances(hits, each, world), mount, loss="cauchy", f_scale=GATE).x
    near = hits[_distances(hits, mount, world) <= NEAR]
    return _fitted(near, mount, world).x if len(near) >= FEWEST // 2 else mount


def _fitted(hits: np.ndarray, mount: np.ndarray, world: World) -> "OptimizeResult":
    from scipy.optimize import least_squares

    return least_squares(lambda each: _distances(hits, each, world), mount)


def _distances(hits: np.ndarray, mount: np.ndarray, world: World) -> np.ndarray:
    """(m,) distance of each hit from the nearest surface [m]."""
    on_robot = mount[:2] + rotate_rows(hits[:, :2], np.full(len(hits), mount[2]))
    return surface_distances(world, hits[:, 2:4] + rotate_rows(on_robot, hits[:, 4]))


def _certainty(hits: np.ndarray, mount: np.ndarray, world: World) -> tuple[float, np.ndarray]:
    """Root mean square distance of the explained hits [m], and the standard deviations that it gives x, y and yaw."""
    near = hits[_distances(hits, mount, world) <= NEAR]
    if not len(near):
        return math.nan, np.full(3, math.inf)
    fit = _fitted(near, mount, world)
    error, size = math.sqrt(2.0 * fit.cost / len(near)), fit.jac.T @ fit.jac
    if np.linalg.cond(size) > 1e9:
        return error, np.full(3, math.inf)
    return error, error * np.sqrt(np.diag(np.linalg.inv(size)))
