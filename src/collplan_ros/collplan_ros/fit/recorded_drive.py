"""The stretches of recorded runs that nothing but the wheels drives."""

import numpy as np

from collplan_core.calibration.drive_filter import FIRST
from collplan_core.calibration.drive_fit import DrivenStretches
from collplan_core.calibration.impact_fit import FAR, NEAR
from collplan_core.worlds import surface_distances
from collplan_ros.fit.recorded_path import FittedRun

CLEAR = 0.02
"""Distance of the robot's rim from every surface above which it touches none: noise, and errors of the world [m]."""
LONGEST_GAP = 0.05
"""Time between two poses beyond which commands between them may be unknown [s]."""


def driven_stretches(run: FittedRun) -> DrivenStretches:
    """The stretches of a run that are commanded and away from walls, and from touches some time before and after."""
    times, points, wanted = run.path.times, run.path.points, run.path.wanted
    near = times[surface_distances(run.world, points) < run.settings.robot.radius + CLEAR]
    beside = np.concatenate([[-np.inf], near, [np.inf]])
    following = np.searchsorted(near, times)
    away = (times - beside[following] > FAR) & (beside[following + 1] - times > NEAR)
    away &= np.hypot(*wanted.T) > 0.0
    return DrivenStretches(
        name=run.name,
        times=times,
        points=points,
        wanted=wanted,
        stretches=_stretches(away, np.diff(times) > LONGEST_GAP),
        period=1.0 / run.settings.controller.rate,
        noise=run.settings.mocap.position_noise,
    )


def _stretches(away: np.ndarray, gaps: np.ndarray) -> np.ndarray:
    """(m, 2) first pose and the one after the last of each stretch of enough poses."""
    joined = away[:-1] & away[1:] & ~gaps
    edges = np.diff(np.concatenate([[False], joined, [False]]).astype(int))
    # a run of joined pairs has one pose more than pairs
    stretches = np.stack([np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) + 1], axis=1)
    return stretches[stretches[:, 1] - stretches[:, 0] > 2 * FIRST]
