"""Trials in which the LIDAR begins to lie while the robot drives."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from shifted_starts import shifted
from watched_trials import Watched, watched_trial

from collplan_core.scan import Scan

FAMILIES = ("corridor", "random", "serpentine", "u", "l", "z", "baffles", "pillars")
SPEED = 0.5
"""A scan lies once the robot drives so fast [m/s]."""
Lie = Callable[[list[Scan], int, np.random.Generator], Scan]
"""The scan given instead of the newest of all true ones; the number of the first that lies; the lie's own chance."""


def nothing_near(scans: list[Scan], begun: int, random: np.random.Generator) -> Scan:
    return replace(scans[-1], ranges=np.full(len(scans[-1].ranges), np.inf))


def half_empty(scans: list[Scan], begun: int, random: np.random.Generator) -> Scan:
    ranges = scans[-1].ranges.copy()
    n = len(ranges)
    ranges[(random.integers(n) + np.arange(n // 2)) % n] = np.inf
    return replace(scans[-1], ranges=ranges)


def frozen(scans: list[Scan], begun: int, random: np.random.Generator) -> Scan:
    return replace(scans[-1], ranges=scans[begun - 1].ranges)


def lost(scans: list[Scan], begun: int, random: np.random.Generator) -> Scan:
    ranges = scans[-1].ranges.copy()
    ranges[random.random(len(ranges)) < 0.6] = np.nan
    return replace(scans[-1], ranges=ranges)


def late(delay: float) -> Lie:
    """What was seen `delay` [s] ago, with the stamp of then."""
    return lambda scans, begun, random: _before(scans, delay)


def late_unnoticed(delay: float) -> Lie:
    """What was seen `delay` [s] ago, stamped as if it were new."""
    return lambda scans, begun, random: replace(_before(scans, delay), stamp=scans[-1].stamp)


def _before(scans: list[Scan], delay: float) -> Scan:
    return next((scan for scan in reversed(scans) if scan.stamp <= scans[-1].stamp - delay + 1e-6), scans[0])


LIES: dict[str, Lie] = {
    "nothing near": nothing_near,
    "half empty": half_empty,
    "frozen": frozen,
    "lost": lost,
    "late 0.3 s": late(0.3),
    "late 0.5 s": late(0.5),
    "late 0.3 s unnoticed": late_unnoticed(0.3),
    "late 0.5 s unnoticed": late_unnoticed(0.5),
}


class Lying(Watched):
    """Its LIDAR lies once it drives as fast as SPEED; None never does.

    Attributes:
        begun: when the first scan lied [s]; NaN where none did.
    """

    def __init__(self, lie: Lie | None, seed: int, *given) -> None:
        super().__init__(*given)
        self.begun, self._lie, self._seed = float("nan"), lie, seed
        self._true_scans: list[Scan] = []
        self._first: int | None = None

    def _take_scan(self, scan: Scan) -> None:
        self._true_scans.append(scan)
        fast = np.hypot(*self._state.velocity) >= SPEED
        if self._lie and self._first is None and fast and len(self._true_scans) > 1:
            self._first, self.begun = len(self._true_scans) - 1, self._state.stamp
        if self._lie and self._first is not None:
            scan = self._lie(self._true_scans, self._first, np.random.default_rng(self._seed))
        super()._take_scan(scan)

    @property
    def stood(self) -> float:
        """Time from the first lie until the first command of zero for a reason of the scans [s]; inf without."""
        times = [row.time for row in self.said if row.time >= self.begun and row.reason.startswith("scan")]
        return times[0] - self.begun if times else np.inf

    @property
    def stood_for(self) -> list[str]:
        """Reasons of a scan for which the robot stood after its first command that moves."""
        begun = next((row.time for row in self.said if row.speed > 0.0), np.inf)
        return [row.reason for row in self.said if row.time > begun and row.reason.startswith("scan")]

    @property
    def worst_hit(self) -> float:
        """Fastest hit after the first lie, or of all where there is none [m/s]; 0 without any."""
        hits = (impact_speed(impact) for impact in self.result.impacts if not impact.time < self.begun)
        return max(hits, default=0.0)


def lying_trial(lie: Lie | None, world: str, strategy: str, seed: int, shift: float = 0.0, **values: object) -> Lying:
    """A trial in which the LIDAR lies from SPEED on; it starts so far aside [m]."""
    return watched_trial(shifted(world, shift), strategy, seed, partial(Lying, lie, seed), **values)


def impact_speed(impact) -> float:
    return float(-impact.velocity_before @ impact.normal)


def world(seed: int) -> str:
    family = FAMILIES[seed % len(FAMILIES)]
    return family if family == "corridor" else f"{family}:{seed}"
