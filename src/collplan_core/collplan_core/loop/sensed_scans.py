"""Scans placed among the poses and judged, once for every loop that is given the same poses and scans."""

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from collplan_core.control.permission import is_relocated
from collplan_core.local_map import LocalMap
from collplan_core.local_map.build import map_of_surfaces
from collplan_core.local_map.seen import SeenSurfaces, of_each_beam, seen_surfaces
from collplan_core.movers.coverage import Coverage, with_view
from collplan_core.movers.finding import MoverMemory, find_movers
from collplan_core.movers.record import ALL_SEEN, MOVES, NO_MOVERS, Movers, SortedReturns, Unseen
from collplan_core.parameters import LocalMapping, Settings
from collplan_core.planners import local_mapping_of
from collplan_core.poses.pose_history import PoseHistory
from collplan_core.scan import Scan
from collplan_core.scans.filters import masked_beams, used_scan
from collplan_core.scans.placing import beam_poses, placed
from collplan_core.scans.plausibility import ScanMemory, judge_scan
from collplan_core.scans.wall_lines import on_wall_lines, range_noise
from collplan_core.state import State


@dataclass(frozen=True, eq=False)
class PlacedScan:
    """A scan whose pose is known, without the returns of movers, the state at its stamp, and the local map of both."""

    scan: Scan
    state: State
    local_map: LocalMap


MAPS = 2
"""Local maps that are kept: the newest scan's, and that of the scan that a plan was made from."""
Judged = list[tuple[str, float]]
"""Verdict on each scan: why it is refused, "" where it is accepted, and its time of receipt [s, local clock]."""


class SensedScans:
    """The recent poses and scans. A pose that does not join the one before clears both.

    A scan is used once the poses of all its beams are known, and then only if it is plausible after those before it,
    also across a gap or jump of the poses: a kidnapped robot finds the walls where they were. The newest pose or scan
    given again at the same time, by another loop, changes nothing and returns the same.
    """

    def __init__(self, span: float) -> None:
        """Keeps poses and scans for `span` [s] by their stamps."""
        self.movers: Movers = NO_MOVERS  # what moves, by the scans so far
        self.unseen: Unseen = ALL_SEEN  # what the newest of them has out of view, and none before had in view
        self._coverage: Coverage | None = None
        self._span = span
        self._poses = PoseHistory(span)
        self._unplaced: list[tuple[Scan, float]] = []
        self._scans: deque[tuple[Scan, SeenSurfaces, SortedReturns, Unseen]] = deque()
        self._memory, self._moving = ScanMemory(), MoverMemory()
        self._mapped: deque[tuple[PlacedScan, LocalMapping]] = deque(maxlen=MAPS)
        self._state: State | None = None
        self._given: tuple[object, float] = (None, math.nan)
        self._joins = True
        self._judged: Judged = []

    def take_pose(self, state: State, local: float, settings: Settings) -> tuple[bool, Judged]:
        """Adds a pose received at `local` [s, local clock]; returns whether it joins the one before, and judged scans.

        The first pose joins. The scans are those that can be judged by now.
        """
        if not self._is_given(state, local):
            before, margin = self._state, settings.mocap.leap_margin
            self._joins = before is None or not is_relocated(before, state, settings.robot, settings.limits, margin)
            if not self._joins:
                self._poses.clear()
                self._scans.clear()
                self._unplaced = []
                self.movers, self._moving = NO_MOVERS, MoverMemory()
                self.unseen, self._coverage = ALL_SEEN, None
            self._poses.add(state)
            self._state, self._given = state, (state, local)
            self._place_scans(settings)
        return self._joins, self._judged

    def take_scan(self, scan: Scan, local: float, settings: Settings) -> Judged:
        """Adds a scan received at `local` [s, local clock]; returns the scans that can be judged by now.

        Raises:
            ScanError: nothing is left of it.
        """
        if not self._is_given(scan, local):
            used, self._given = used_scan(scan, settings.scan), (scan, local)
            waiting = [each for each in self._unplaced if scan.stamp - self._span <= each[0].stamp < scan.stamp]
            self._unplaced = [*waiting, (used, local)]
            self._place_scans(settings)
        return self._judged

    def _is_given(self, new: State | Scan, local: float) -> bool:
        return new is self._given[0] and local == self._given[1]

    @property
    def vouched(self) -> bool:
        """Whether walls are near by which a wrong scan would be noticed; false before the first scan."""
        return self._memory.vouches

    def forget(self) -> None:
        """Accepts the next scan, whatever it shows."""
        self._memory = ScanMemory()

    def _place_scans(self, settings: Settings) -> None:
        """Judges the scans whose poses have become known."""
        unplaced, self._unplaced, self._judged = self._unplaced, [], []
        for scan, local in unplaced:
            beams, state = beam_poses(scan, self._poses, settings.scan), self._poses.at(scan.stamp)
            if beams is None or state is None:
                self._unplaced.append((scan, local))
                continue
            noise = range_noise(scan)
            shown = on_wall_lines(placed(scan, beams, state, settings.scan), noise)
            seen, masked = seen_surfaces(shown, state), masked_beams(scan, settings.scan)
            if np.isposinf(scan.ranges).any():
                masked = masked | of_each_beam(seen.fades, scan, missing=False)
            returns, moving = find_movers(self._moving, scan, noise, seen, state, settings.movers)
            moves, in_view = returns.kinds == MOVES, seen
            if moves.any():
                # what moves is no wall, and hides those behind it
                of_movers = of_each_beam(moves, shown, missing=False)
                shown, masked = replace(shown, ranges=np.where(of_movers, np.nan, shown.ranges)), masked | of_movers
                seen = seen_surfaces(shown, state)
            moved = np.concatenate([returns.swept, returns.trails])
            reason, self._memory = judge_scan(self._memory, scan, masked, beams, seen, state, settings.limits, moved)
            self._judged.append((reason, local))
            if not reason:
                self.movers, self._moving = returns.movers, moving
                self._coverage, self.unseen = with_view(self._coverage, in_view, state, settings.robot.radius)
                self._keep(shown, seen, returns)

    def _keep(self, scan: Scan, seen: SeenSurfaces, returns: SortedReturns) -> None:
        if self._scans and scan.stamp <= self._scans[-1][0].stamp:
            self._scans.clear()
        self._scans.append((scan, seen, returns, self.unseen))
        while self._scans[0][0].stamp < scan.stamp - self._span:
            self._scans.popleft()

    @property
    def unplaced_received(self) -> float:
        """Time of receipt of the newest scan whose poses are not known yet [s, local clock]; -inf without one."""
        return max((at for _, at in self._unplaced), default=-math.inf)

    @property
    def scan_stamp(self) -> float | None:
        """Stamp of the newest scan that was not refused [s]; None before the first."""
        if self._unplaced:
            return self._unplaced[-1][0].stamp
        return self._scans[-1][0].stamp if self._scans else None

    def newest_placed(self, after: float = -math.inf, until: float = math.inf) -> tuple[Scan, State] | None:
        """The newest scan whose poses are known, and the pose at its stamp, which is in (after, until] [s]."""
        found = self._newest(after, until)
        return found[:2] if found else None

    def newest_mapped(self, settings: Settings, after: float = -math.inf, until: float = math.inf) -> PlacedScan | None:
        """The newest scan of that time with its local map, which is made once for all loops that ask for it."""
        found, mapping = self._newest(after, until), local_mapping_of(settings)
        if found is None:
            return None
        scan, state, seen, returns, unseen = found
        for made, by in self._mapped:
            if made.scan is scan and by == mapping:
                return made
        made = PlacedScan(scan, state, map_of_surfaces(seen, state, settings.robot, mapping, returns, unseen))
        self._mapped.append((made, mapping))
        return made

    def _newest(self, after: float, until: float) -> tuple[Scan, State, SeenSurfaces, SortedReturns, Unseen] | None:
        for scan, seen, returns, unseen in reversed(self._scans):
            state = self._poses.at(scan.stamp) if after < scan.stamp <= until else None
            if state is not None:
                return scan, state, seen, returns, unseen
        return None

    def pose_at(self, stamp: float) -> State | None:
        """The pose at this stamp [s]; None where it is not known, as before a relocation."""
        return self._poses.at(stamp)
