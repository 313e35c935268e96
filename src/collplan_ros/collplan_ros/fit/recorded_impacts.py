"""The impacts of recorded runs, in the frames of the walls."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from collplan_core.calibration.drive_fit import DriveFit
from collplan_core.calibration.impact_fit import FAR, NEAR, ImpactFit, UnusableImpact, fit_impact
from collplan_core.calibration.impact_search import find_impacts
from collplan_core.calibration.wall_impacts import WallImpacts, seen_from_walls, sorted_out
from collplan_core.plane import nearest_on_segment
from collplan_core.worlds import World, surface_distances, world_segments
from collplan_ros.fit.recorded_drive import CLEAR
from collplan_ros.fit.recorded_path import FittedRun

FARTHEST_WALL = 0.02
"""Largest distance between the robot's rim and the nearest surface at an impact [m]: noise, and errors of the world."""
SPIN_SPAN = 0.06
"""Span of the poses before an impact from which the spin is taken [s]."""


def measured_impacts(runs: Sequence[FittedRun], drive: DriveFit) -> tuple[WallImpacts, Counter[str]]:
    """The usable impacts of all runs, and the number of others by reason.

    The drive fitted to the same runs gives the wheels' motion around an impact. The normal is that of
    the world's nearest surface: from the change of velocity it could be found only if the friction were known.
    """
    impacts, normals, depths, spins, left_out = [], [], [], [], Counter[str]()
    for run, bias in zip(runs, drive.biases, strict=True):
        driven = _with_drive(run, drive, bias)
        times = _hit_times(driven)
        for time in times:
            try:
                impact, normal, depth = _measured_impact(driven, time, times)
            except UnusableImpact as error:
                left_out[str(error)] += 1
                continue
            impacts.append(impact)
            normals.append(normal)
            depths.append(depth)
            spins.append(_spin_before(driven, impact.time))
    radius = runs[0].settings.robot.radius
    usable, others = sorted_out(seen_from_walls(impacts, np.array(normals), depths, spins, radius))
    return usable, left_out + others


def _hit_times(run: FittedRun) -> list[float]:
    """Times of the hits [s]: of touches of the world's walls, and of kinks in the path far from any.

    Kinks alone would leave out hits of little change, and so bias the result upwards.
    """
    times, points = run.path.times, run.path.points
    distances = surface_distances(run.world, points) - run.settings.robot.radius
    near = np.flatnonzero(distances < CLEAR)
    touches = np.split(near, np.flatnonzero(np.diff(near) > 1) + 1) if len(near) else []
    hits = [float(times[touch[distances[touch].argmin()]]) for touch in touches]
    kinks = find_impacts(times, points, run.settings)
    return sorted(hits + [kink for kink in kinks if all(abs(kink - hit) > FAR for hit in hits)])


def _with_drive(run: FittedRun, drive: DriveFit, bias: tuple[float, float]) -> FittedRun:
    """The run with the fitted drive in place of its own parameters, and the wheels' target as its commands."""
    found = {
        "robot.max_acceleration": drive.max_acceleration.value,
        "robot.velocity_lag": drive.velocity_lag.value,
    }
    commanded = np.hypot(*run.path.wanted.T)[:, np.newaxis] > 0.0
    path = replace(run.path, wanted=run.path.wanted + np.where(commanded, bias, 0.0))
    return replace(run, settings=run.settings.with_values(found), path=path)


def _measured_impact(run: FittedRun, time: float, times: Sequence[float]) -> tuple[ImpactFit, np.ndarray, float]:
    """The impact, the wall's normal (2,), and how far the robot was past its first touch [m]."""
    if sum(abs(other - time) < FAR for other in times) > 1:
        raise UnusableImpact(f"another hit within {FAR:g} s")
    impact = fit_impact(run.path, time, run.settings.robot, run.settings.mocap.position_noise)
    point, normal = nearest_surface(run.world, impact.position)
    depth = run.settings.robot.radius - float(np.linalg.norm(impact.position - point))
    # negated, because the point is NaN in a world without surfaces
    if not abs(depth) <= FARTHEST_WALL:
        raise UnusableImpact("no surface of the world at the robot's rim")
    return impact, normal, depth


def _spin_before(run: FittedRun, time: float) -> float:
    """Yaw rate before an impact at `time` [rad/s]; no pose of the impact itself is used."""
    times = run.path.times - time
    before = (times >= -SPIN_SPAN - 0.5 * NEAR) & (times <= -0.5 * NEAR)
    return float(np.polyfit(times[before], run.yaws[before], 1)[0]) if before.sum() > 1 else 0.0


def nearest_surface(world: World, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The point (2,) of the world's surfaces nearest to a free position (2,) [m], and the unit normal (2,) there.

    Both are NaN in a world without surfaces.
    """
    on_segments = [nearest_on_segment(*segment, *position) for segment in world_segments(world)]
    points = np.array(on_segments).reshape(-1, 2)
    if len(world.circles):
        outward = position - world.circles[:, :2]
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        points = np.vstack([points, world.circles[:, :2] + outward * world.circles[:, 2:]])
    if len(points) == 0:
        return np.full(2, np.nan), np.full(2, np.nan)
    away = position - points
    distances = np.linalg.norm(away, axis=1)
    nearest = int(distances.argmin())
    return points[nearest], away[nearest] / distances[nearest]
