"""The mount at which pairs of scans agree best, and how sure it is: the pairs are redrawn, and each draw is fitted."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from collplan_core.mounting.agreement import Mount, disagreements
from collplan_core.mounting.driven import Driven, Pairs, pairs_of

HEADINGS = 24
"""Headings tried first, evenly over the full turn, either way round."""
STAMPS = (-0.45, -0.35, -0.25, -0.15, -0.05, 0.05)
"""Starts of the sweep tried first [s]."""
REFINED = 4
"""Number of coarse mounts that are refined, with each beam order."""
UNITS = np.array([0.1, 0.1, 0.1, 0.1])
"""Units of start [s], x, y [m] and heading [rad] in which one step changes the agreement alike."""
DRAWS = 8
FLOORS = np.array([0.03, 0.04, 0.04, 0.05])
"""Smallest uncertainty of start [s], x, y [m] and heading [rad]: what is wrong in all pairs alike, as an odometry that
turns too little, shows in no spread. Headings of real robots were off by up to 0.05 rad at a spread of 0.002."""
KNOWN = np.array([0.1, 0.08, 0.08, 0.15])
"""Uncertainty beyond which a value is not told, in the same order."""
CLEAR = 3.0
"""Standard errors by which the pairs must prefer a heading or a sweep to the next best."""
APART = math.radians(20.0)
"""Headings farther apart are different mounts."""
FARTHEST = 1.0
"""Largest distance of a LIDAR from the robot's centre that is tried [m]."""


@dataclass(frozen=True, eq=False)
class MountFit:
    """The mount found."""

    mount: Mount  # the mount, whose sweep is the one given where the scans do not tell
    uncertainty: np.ndarray  # (4,) of start [s], x, y [m] and heading [rad]: the truth is within it in 95 of 100
    known: np.ndarray  # (4,) bool, whether each was shown
    sweep_known: bool  # whether the sweep was shown
    clear: bool  # whether heading and sense of rotation are preferred clearly; else nothing is known
    agreement: float  # mean distance of the returns from the surfaces of the other scan [m]


def fit_mount(driven: Driven, given: int, said: Callable[[float], None] = lambda share: None) -> MountFit | None:
    """Fits mount, stamp and sweep with nothing told; None where the robot hardly moved.

    Args:
        given: sweep as it is set, which is kept where the scans do not tell, as in `Mount.sweep`.
        said: takes the share of the work that is done.
    """
    pairs = pairs_of(driven)
    if not (pairs.shows_turns or pairs.shows_ways):
        return None
    coarse = _coarse(driven, pairs.scans[::3])
    said(0.1)
    found: list[tuple[float, Mount]] = []
    sweeps = (1, -1, 0) if driven.between else (0,)
    half = pairs.scans[::2]
    for at, start in enumerate(coarse):
        for sweep in sweeps:
            found.append(_refined(driven, half, start._replace(sweep=sweep), 160))
        said(0.1 + 0.5 * (at + 1) / len(coarse))
    best = min(found, key=_score)[1]
    alike = [each for each in found if _is_alike(each[1], best)]
    kinds = [
        min((each for each in alike if each[1].sweep == sweep), key=_score) for sweep in {e[1].sweep for e in alike}
    ]
    kinds = sorted((_refined(driven, pairs.scans, mount, 160) for _, mount in kinds), key=_score)
    best = kinds[0][1]
    sweep_known = len(sweeps) > 1 and all(_is_clearly(driven, pairs, best, other) for _, other in kinds[1:])
    if not sweep_known:
        best = next((mount for _, mount in kinds if mount.sweep == given), best)
    rivals = [each for each in found if not _is_alike(each[1], best)]
    said(0.7)
    spread = _spread(driven, pairs, best, said)
    uncertainty = np.hypot(2.0 * spread, FLOORS)
    known = np.array([pairs.shows_turns] * 3 + [pairs.shows_ways]) & (uncertainty <= KNOWN)
    # turns alone show the place as seen from the LIDAR, which its heading turns
    known[1:3] &= known[3]
    return MountFit(
        best,
        uncertainty,
        known,
        sweep_known and pairs.shows_turns,
        not rivals or _is_clearly(driven, pairs, best, min(rivals, key=_score)[1]),
        float(disagreements(driven, pairs.scans, best).mean()),
    )


def _coarse(driven: Driven, scans: np.ndarray) -> list[Mount]:
    """The best mounts at the robot's centre, of different headings."""
    tried = [
        Mount(late, 0.0, 0.0, math.tau * k / HEADINGS, 0, mirrored)
        for mirrored in (False, True)
        for k in range(HEADINGS)
        for late in STAMPS
    ]
    tried.sort(key=lambda mount: float(disagreements(driven, scans, mount).mean()))
    chosen: list[Mount] = []
    for mount in tried:
        if not any(_is_alike(mount, other) for other in chosen):
            chosen.append(mount)
    return chosen[:REFINED]


def _is_alike(a: Mount, b: Mount) -> bool:
    return a.mirrored == b.mirrored and abs(math.remainder(a.yaw - b.yaw, math.tau)) <= APART


def _score(fitted: tuple[float, Mount]) -> float:
    return fitted[0]


def _refined(driven: Driven, scans: np.ndarray, start: Mount, evaluations: int) -> tuple[float, Mount]:
    # costs more than all the rest to load
    from scipy.optimize import minimize

    def mount_of(values: np.ndarray) -> Mount:
        late, x, y, yaw = (values * UNITS).tolist()
        return start._replace(late=late, x=x, y=y, yaw=start.yaw + yaw)

    def cost(values: np.ndarray) -> float:
        mount = mount_of(values)
        beyond = max(math.hypot(mount.x, mount.y) - FARTHEST, 0.0) + max(abs(mount.late) - 0.5, 0.0)
        return float(disagreements(driven, scans, mount).mean()) + beyond

    first = np.array([start.late, start.x, start.y, 0.0]) / UNITS
    simplex = np.vstack([first, first + np.diag([0.6, 0.8, 0.8, 0.6])])
    options = {"maxfev": evaluations, "initial_simplex": simplex, "xatol": 0.01, "fatol": 1e-5}
    result = minimize(cost, first, method="Nelder-Mead", options=options)
    mount = mount_of(result.x)
    return float(result.fun), mount._replace(yaw=math.remainder(mount.yaw, math.tau))


def _is_clearly(driven: Driven, pairs: Pairs, best: Mount, other: Mount) -> bool:
    """Returns whether the pairs prefer one mount to another beyond chance."""
    less = disagreements(driven, pairs.scans, other) - disagreements(driven, pairs.scans, best)
    return bool(less.mean() > CLEAR * less.std() / math.sqrt(len(less)))


def _spread(driven: Driven, pairs: Pairs, best: Mount, said: Callable[[float], None]) -> np.ndarray:
    """(4,) standard deviations of start [s], x, y [m] and heading [rad] over pairs drawn anew."""
    # Each fit begins elsewhere: a value that the motion does not show stays where it began, and is seen to be unknown.
    random, found = np.random.default_rng(0), []
    for draw in range(DRAWS):
        late, x, y, yaw = (np.array([best.late, best.x, best.y, best.yaw]) + random.normal(0.0, 0.07, 4)).tolist()
        drawn = pairs.scans[random.integers(len(pairs.scans), size=len(pairs.scans))]
        mount = _refined(driven, drawn, best._replace(late=late, x=x, y=y, yaw=yaw), 110)[1]
        found.append((mount.late, mount.x, mount.y, math.remainder(mount.yaw - best.yaw, math.tau)))
        said(0.7 + 0.3 * (draw + 1) / DRAWS)
    return np.array(found).std(axis=0)
