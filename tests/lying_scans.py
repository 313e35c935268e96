"""Trials in which the LIDAR begins to lie while the robot drives."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from shifted_starts import shifted

from collplan_core.parameters import Settings
from collplan_core.scan import Scan
from collplan_core.sensing.instant_lidar import InstantLidar
from collplan_core.state import State
from omnipuck_sim.trial import run_trial
from omnipuck_sim.trial_record import TrialRecord, TrialResult

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


@dataclass
class Watched:
    """One trial.

    Attributes:
        begun: when the first scan lied [s]; NaN where none did.
        commands: time [s], whether it is zero, and the reason to stand still, of each command.
        hits: time [s] and speed into the wall [m/s] of each impact.
    """

    begun: float = float("nan")
    commands: list[tuple[float, bool, str]] = field(default_factory=list)
    hits: list[tuple[float, float]] = field(default_factory=list)
    result: TrialResult | None = None

    @property
    def stood(self) -> float:
        """Time from the first lie until the first command of zero for a reason of the scans [s]; inf without."""
        times = [t for t, _, reason in self.commands if t >= self.begun and reason.startswith("scan")]
        return times[0] - self.begun if times else np.inf

    @property
    def held(self) -> list[str]:
        """Reasons of a scan for which the robot stood after its first scan."""
        begun = next((t for t, zero, _ in self.commands if not zero), np.inf)
        return [reason for t, _, reason in self.commands if t > begun and reason.startswith("scan")]

    @property
    def worst_hit(self) -> float:
        """Fastest hit after the first lie, or of all where there is none [m/s]; 0 without any."""
        return max((speed for t, speed in self.hits if not t < self.begun), default=0.0)


def watched_trial(
    lie: Lie | None, world: str, strategy: str, seed: int, shift: float = 0.0, **values: object
) -> Watched:
    """A trial in which the ideal LIDAR lies from SPEED on; it starts so far aside [m]."""
    watched, true_scans = Watched(), []
    scan_at, commanded = InstantLidar.scan, TrialRecord.commanded
    first = None

    def scan(lidar: InstantLidar, state: State) -> Scan:
        nonlocal first
        true_scans.append(scan_at(lidar, state))
        fast = np.hypot(*state.velocity) >= SPEED
        if lie and first is None and fast and len(true_scans) > 1:
            first, watched.begun = len(true_scans) - 1, state.stamp
        return true_scans[-1] if first is None or lie is None else lie(true_scans, first, np.random.default_rng(seed))

    def listen(record: TrialRecord, command, now: float) -> None:
        watched.commands.append((now, not command.velocity.any(), command.reason))
        commanded(record, command, now)

    settings = Settings().with_values({"planner.strategy": strategy, **values})
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(InstantLidar, "scan", scan)
        patched.setattr(TrialRecord, "commanded", listen)
        watched.result = run_trial(shifted(world, shift), settings, seed)
    watched.hits = [(impact.time, impact_speed(impact)) for impact in watched.result.impacts]
    return watched


def impact_speed(impact) -> float:
    """Speed into the wall [m/s]."""
    return float(-impact.velocity_before @ impact.normal)


def world(seed: int) -> str:
    family = FAMILIES[seed % len(FAMILIES)]
    return family if family == "corridor" else f"{family}:{seed}"
