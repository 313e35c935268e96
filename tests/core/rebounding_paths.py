"""Recorded paths with a hit whose constants are known; the wall is the line through the origin."""

from dataclasses import dataclass

import numpy as np

from collplan_core.calibration.impact_fit import RecordedPath
from collplan_core.parameters import Robot

ROBOT = Robot()
NOISE = 0.002
"""[m]."""
HIT = 0.35
"""When [s], about."""
_STEP = 1e-3


@dataclass(frozen=True, eq=False)
class KnownHit:
    """Time [s], velocities before and after (2,) [m/s], unit normal (2,) of the wall."""

    time: float
    before: np.ndarray
    after: np.ndarray
    normal: np.ndarray


def rebounding_path(
    into: float, along: float, restitution: float, friction: float, angle: float = 0.0, end: float = 0.8
) -> tuple[RecordedPath, KnownHit]:
    """Driven at a wall and away again, 100 poses a second without noise; the wall's normal is turned by `angle`."""
    normal = np.array([np.cos(angle), np.sin(angle)])
    tangent = np.array([-normal[1], normal[0]])
    wanted, velocity = -1.2 * into * normal + along * tangent, -into * normal + 0.9 * along * tangent
    position, known = -velocity * HIT, None
    times, points, commands = [], [], []
    for step in range(round(end / _STEP)):
        if step % 10 == 0:
            # the controller notices late
            if known is not None and step * _STEP > known.time + 0.05:
                wanted = 0.5 * into * normal - 0.3 * along * tangent
            times.append(step * _STEP)
            points.append(position)
            commands.append(wanted)
        velocity = velocity + _driven(velocity, wanted)
        position = position + velocity * _STEP
        if position @ normal < 0.0 and known is None:
            after = _rebound(velocity, normal, restitution, friction)
            known, velocity = KnownHit(step * _STEP, velocity, after, normal), after
    assert known is not None
    return RecordedPath(np.array(times), np.array(points), np.array(commands)), known


def _rebound(velocity: np.ndarray, normal: np.ndarray, restitution: float, friction: float) -> np.ndarray:
    """Coulomb friction, no spin before."""
    into, tangent = -float(velocity @ normal), np.array([-normal[1], normal[0]])
    along = float(velocity @ tangent)
    stopped = np.sign(along) * min(friction * (1.0 + restitution) * into, abs(along) * ROBOT.inertia_factor)
    return restitution * into * normal + (along - stopped) * tangent


def _driven(velocity: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    acceleration = (wanted - velocity) / ROBOT.velocity_lag
    size = float(np.linalg.norm(acceleration))
    return acceleration * min(1.0, ROBOT.max_acceleration / size if size > 0.0 else 1.0) * _STEP


def with_noise(path: RecordedPath, random: np.random.Generator) -> RecordedPath:
    return RecordedPath(path.times, path.points + random.normal(0.0, NOISE, path.points.shape), path.wanted)
