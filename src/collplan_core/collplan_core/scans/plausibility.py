"""Plausibility of a scan after earlier ones: walls do not vanish, and a scan changes while the robot moves.

Walls vouch for a scan: surfaces long enough, where no mover has been, not older than a second. What is shorter vouches
too while the robot moves. Where too few walls are near, a scan that lies may pass as a true one.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.seen import SeenSurfaces
from collplan_core.parameters import Limits
from collplan_core.scan import Scan
from collplan_core.scans.consistency import MOVING, Consistency, scan_consistency
from collplan_core.scans.remembered_walls import wall_of_each_beam
from collplan_core.state import State

KEPT, PERIOD, LASTS = 5, 0.2, 1.0
"""Number of scans kept, the time between them, and the age from which on none counts [s]: what stood may be gone."""
BESIDE = 0.25
"""Walls so near to where a mover has been were its own [m]."""
FEWEST, FEWEST_AHEAD = 40, 30
"""Smallest number of walls, of all scans kept together, for a verdict."""
MOST_MISSING_AHEAD = 0.5
"""Largest share of the beams ahead, which are few, that may miss a wall."""
MOST_BLIND = 0.5
"""Largest share of the beams that showed nothing in place of a wall that may go on showing nothing."""
LATEST = 0.1
"""A scan whose content is older than its stamp by more is late [s]; the sweep of a LIDAR of 10 Hz that gives no
time_increment is 0.05 s late on average."""
STILL, UNTURNED = 0.02, 0.02
"""A robot that moved less than this may see the same to the last bit: poses have noise [m, rad]."""
REPEATED = "the same to the last bit"
"""Begin of the reason of a scan that repeats one: it is none, and neither refused nor used."""
NOWHERE, NO_WALLS = np.zeros((0, 3)), np.zeros((0, 5))


@dataclass(frozen=True, eq=False)
class ScanMemory:
    """Memory by which the next scan is judged."""

    walls: tuple[tuple[float, np.ndarray], ...] = ()
    """What stood in plausible scans, the newest last: stamp [s] and the rows of `wall_of_each_beam`."""
    ranges: bytes = b""  # ranges of the newest scan, plausible or not; empty before the first
    pose: tuple[float, float, float] = (math.nan, math.nan, math.nan)
    """(3,) x, y [m] and yaw [rad] where those ranges came first."""
    blind: tuple[int, ...] = ()
    """Beams without a wall that was there, of the newest scan that missed too many; empty after a plausible one."""

    @cached_property
    def vouches(self) -> bool:
        """Whether there are walls enough to tell that the next scan lies."""
        return sum(float(walls[:, 4].sum()) for _, walls in self.walls) >= FEWEST


def judge_scan(
    memory: ScanMemory,
    scan: Scan,
    masked: np.ndarray,
    beams: np.ndarray,
    seen: SeenSurfaces,
    state: State,
    limits: Limits,
    moved: np.ndarray = NOWHERE,
) -> tuple[str, ScanMemory]:
    """Returns the reason why a scan is implausible, "" where it is plausible, and the memory for the next scan.

    Args:
        masked: (n,) whether a beam is masked: it need not show a wall.
        beams: (n, 3) x, y [m] and yaw [rad] of the sensor at each beam, of `beam_poses`.
        seen: the surfaces in the scan; state: the robot at its stamp.
        moved: (m, 3) discs x, y, radius [m] where movers have been: what stood there is no wall.
    """
    memory = _with_ranges(memory, scan, beams)
    reason = _lost(scan, masked, limits) or _frozen(memory, scan, beams)
    if reason:
        return reason, memory
    now = wall_of_each_beam(seen, scan, state.position)
    if memory.walls and scan.stamp - memory.walls[0][0] > LASTS:
        memory = replace(memory, walls=tuple(each for each in memory.walls if scan.stamp - each[0] <= LASTS))
    walls = np.concatenate([NO_WALLS, *(walls for _, walls in memory.walls)])
    seen_by = scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max
    x, y = state.velocity.tolist()
    recent = len(walls) - len(memory.walls[-1][1]) if memory.walls else 0
    found = scan_consistency(walls, recent, now, scan.ranges, masked, beams, seen_by, (x, y))
    reason = _missing(found, limits)
    if reason and len(moved):
        return judge_scan(_without_walls(memory, moved, (x, y)), scan, masked, beams, seen, state, limits)
    if reason:
        return reason, replace(
            memory, blind=tuple(np.flatnonzero(found.towards_missing & np.isinf(scan.ranges)).tolist())
        )
    reason = _still_blind(memory, scan) or _late(found, scan)
    return reason, memory if reason else _with_walls(memory, scan.stamp, now)


def _with_ranges(memory: ScanMemory, scan: Scan, beams: np.ndarray) -> ScanMemory:
    ranges = scan.ranges.tobytes()
    if ranges == memory.ranges:
        return memory
    x, y, yaw = beams[0].tolist()
    return replace(memory, ranges=ranges, pose=(x, y, yaw))


def _without_walls(memory: ScanMemory, discs: np.ndarray, velocity: tuple[float, float]) -> ScanMemory:
    """The memory without what stood within BESIDE of discs (m, 3) x, y, radius [m]."""
    # While the robot moves, walls stay: a turned scan shows movers where there are none.
    moving, kept = math.hypot(*velocity) >= MOVING, list[tuple[float, np.ndarray]]()
    for stamp, walls in memory.walls:
        away = np.hypot(walls[:, None, 0] - discs[:, 0], walls[:, None, 1] - discs[:, 1]) > discs[:, 2] + BESIDE
        kept.append((stamp, walls[away.all(axis=1) | (moving & (walls[:, 4] > 0.0))]))
    return replace(memory, walls=tuple(kept))


def _with_walls(memory: ScanMemory, stamp: float, now: np.ndarray) -> ScanMemory:
    memory = replace(memory, blind=()) if memory.blind else memory
    if memory.walls and 0.0 <= stamp - memory.walls[-1][0] < PERIOD - 1e-3:
        return memory
    return replace(memory, walls=(*memory.walls, (stamp, now[~np.isnan(now[:, 0])]))[-KEPT:])


def _lost(scan: Scan, masked: np.ndarray, limits: Limits) -> str:
    share = _lost_share(scan.ranges, masked)
    if share <= limits.lost_beams:
        return ""
    return f"{share:.0%} of the beams are lost, limit {limits.lost_beams:.0%}"


@njit
def _lost_share(ranges: np.ndarray, masked: np.ndarray) -> float:
    lost, used = 0, 0
    for k in range(len(ranges)):
        if not masked[k]:
            used += 1
            lost += math.isnan(ranges[k])
    return lost / used if used > 0 else math.nan


def _frozen(memory: ScanMemory, scan: Scan, beams: np.ndarray) -> str:
    x, y, yaw = beams[0].tolist()
    moved = math.hypot(x - memory.pose[0], y - memory.pose[1])
    turned = abs(math.remainder(yaw - memory.pose[2], math.tau))
    # where nothing is near, all scans are the same
    if (moved <= STILL and turned <= UNTURNED) or not np.isfinite(scan.ranges).any():
        return ""
    return f"{REPEATED} after {moved:.2f} m and {turned:.2f} rad"


def _still_blind(memory: ScanMemory, scan: Scan) -> str:
    """A robot that stands, or drives on a little, has other walls in sight, which do not vouch for these beams."""
    blind = [beam for beam in memory.blind if beam < len(scan.ranges)]
    share = float(np.isinf(scan.ranges[blind]).mean()) if blind else 0.0
    return f"{share:.0%} of the beams that missed walls still show nothing" if share > MOST_BLIND else ""


def _missing(found: Consistency, limits: Limits) -> str:
    if found.expected >= FEWEST and found.missing > limits.missing_beams * found.expected:
        return f"walls seen before are missing in {found.missing / found.expected:.0%} of the beams"
    if found.expected_ahead >= FEWEST_AHEAD and found.missing_ahead > MOST_MISSING_AHEAD * found.expected_ahead:
        share = found.missing_ahead / found.expected_ahead
        return f"walls seen before are missing in {share:.0%} of the beams ahead"
    return ""


def _late(found: Consistency, scan: Scan) -> str:
    if found.n_delays < FEWEST_AHEAD or found.delay <= LATEST:
        return ""
    swept = f"time_increment or scan_time says {scan.sweep:.2f} s a scan: scan.instant? " if scan.sweep else ""
    return f"it shows what was seen {found.delay:.2f} s before its stamp: {swept}scan.stamp_offset?"


def warm_up(scan: Scan, seen: SeenSurfaces, state: State, limits: Limits) -> None:
    """Compiles the comparison by two scans of one place, so that the second scan of a node is not late."""
    beams = np.tile((*state.position.tolist(), state.yaw), (len(scan.ranges), 1))
    masked = np.zeros(len(scan.ranges), bool)
    _, memory = judge_scan(ScanMemory(), scan, masked, beams, seen, state, limits)
    judge_scan(memory, scan, masked, beams, seen, state, limits)
