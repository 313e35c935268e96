"""The recent poses and scans that planner or controller received."""

import math
from collections import deque

from collplan_core.ages import PosesClock
from collplan_core.control.permission import is_relocated, why_stale
from collplan_core.loop.refusals import Refusals
from collplan_core.loop.scan_trust import ScanTrust
from collplan_core.parameters import Limits, Settings
from collplan_core.scan import Scan, ScanError
from collplan_core.sensing.beam_poses import beam_poses, placed
from collplan_core.sensing.pose_history import PoseHistory
from collplan_core.sensing.scan_filters import masked_beams, used_scan
from collplan_core.sensing.scan_plausibility import ScanMemory, judge_scan
from collplan_core.sensing.wall_lines import on_wall_lines
from collplan_core.state import State

REFUSED_POSE_AGE = 0.05
"""Oldest pose acted on while newer ones come and are refused [s]; one of them alone stops nothing at 100 Hz."""


class Sensors:
    """The recent poses and scans, and their age since local receipt [s]. A pose that does not join clears both.

    A scan is used once the poses of all its beams are known, and then only if it can be true after those before it,
    across a gap or leap of the poses too: a robot that was carried off finds the walls where they were.

    Attributes:
        state: newest pose; None before the first.
    """

    def __init__(self, span: float, refusals: Refusals) -> None:
        """Keeps poses and scans for `span` [s] by their stamps, and counts refused ones in `refusals`."""
        self._span = span
        self._refusals = refusals
        self._poses = PoseHistory(span)
        self._unplaced: deque[tuple[Scan, float]] = deque()
        self._scans: deque[Scan] = deque()
        self._scan_memory = ScanMemory()
        self._scan_received = -math.inf
        self._refused: dict[str, str] = {}
        self._trust = ScanTrust()
        self._clock = PosesClock()
        self.state: State | None = None

    def take_pose(self, state: State, local: float, settings: Settings) -> bool:
        """Adds a pose received at `local` [s, local clock]; returns whether it joins the one before, as the first does.

        One that is too far from it in space or time begins anew: what was received before is dropped.
        """
        margin = settings.mocap.leap_margin
        relocated = self.state is not None and is_relocated(self.state, state, settings.robot, settings.limits, margin)
        if relocated:
            self._refusals.add("pose_break", f"the poses begin anew at {state.stamp:.3f}")
            self._poses.clear()
            self._scans.clear()
            self._unplaced.clear()
        self._poses.add(state)
        self._clock.received(state.stamp, local)
        self._refused.pop("pose", None)
        self.state = state
        self._place_scans(settings)
        return not relocated

    def take_scan(self, scan: Scan, local: float, settings: Settings) -> None:
        """Adds a scan received at `local` [s, local clock]."""
        reason = self._why_untimely(scan.stamp, local, settings.limits)
        if reason:
            self._refusals.add("scan", reason)
            self.refuse("scan", reason)
            return
        try:
            scan = used_scan(scan, settings.scan)
        except ScanError as error:
            self._refusals.add("scan", str(error))
            self.refuse("scan", str(error))
            return
        unplaced = [each for each in self._unplaced if scan.stamp - self._span <= each[0].stamp < scan.stamp]
        self._unplaced = deque([*unplaced, (scan, local)])
        self._place_scans(settings)

    def _why_untimely(self, stamp: float, local: float, limits: Limits) -> str:
        """Why a scan with this stamp [s] comes too late, or too early for a pose of its time to come."""
        now = self._clock.now(local)
        late = 0.0 if now is None else now - stamp
        if late > limits.scan_age:
            return f"it comes {late:.2f} s after its stamp, limit {limits.scan_age:.2f} s"
        if -late > limits.pose_age:
            return f"it comes {-late:.2f} s before its stamp, limit {limits.pose_age:.2f} s"
        return ""

    def _place_scans(self, settings: Settings) -> None:
        """Judges the scans whose poses have become known."""
        unplaced, self._unplaced = self._unplaced, deque()
        for scan, local in unplaced:
            beams, state = beam_poses(scan, self._poses, settings.scan), self._poses.at(scan.stamp)
            if beams is None or state is None:
                self._unplaced.append((scan, local))
                continue
            masked = masked_beams(scan, settings.scan)
            reason, self._scan_memory = judge_scan(
                self._scan_memory, scan, masked, beams, state.velocity, settings.limits
            )
            if reason:
                self._refuse_scan(reason, local)
            else:
                self._believe(placed(scan, beams, state, settings.scan), local)

    def _believe(self, scan: Scan, local: float) -> None:
        if self._scans and scan.stamp <= self._scans[-1].stamp:
            self._scans.clear()
        self._scans.append(on_wall_lines(scan))
        self._scan_received = local
        self._trust.believed()
        self._refused.pop("scan", None)
        while self._scans[0].stamp < scan.stamp - self._span:
            self._scans.popleft()

    def _refuse_scan(self, reason: str, local: float) -> None:
        self._refusals.add("scan", reason)
        self._trust.refused(reason, local)
        self.refuse("scan", reason)

    def refuse(self, kind: str, reason: str) -> None:
        """Notes that the newest pose or scan (`kind` "pose" or "scan") cannot be used, and why."""
        self._refused[kind] = reason

    @property
    def refuses_poses(self) -> bool:
        """Whether the newest pose could not be used."""
        return "pose" in self._refused

    def forget_scans(self) -> None:
        """Uses scans again at once; where they are refused, the next one is believed, whatever it shows.

        For a world that did change. Whoever has this called has looked at robot and scan.
        """
        if self._trust.is_lost:
            self._scan_memory = ScanMemory()
            self._refused.pop("scan", None)
        self._trust = ScanTrust()

    def why_lost(self, local: float, limits: Limits) -> str:
        """Why poses or scans that were there are not to be used now; "" where they are, or one of them never came."""
        both_came = self.state is not None and self._scan_received > -math.inf
        return self.why_stale(local, limits) if both_came else ""

    def why_stale(self, local: float, limits: Limits) -> str:
        """Why poses or scans are not to be used: none yet, too old, or the last ones were refused; "" if they are."""
        return self.why_no_pose(local, limits) or self._why_scan(local, limits.scan_age)

    def why_no_pose(self, local: float, limits: Limits) -> str:
        """The same of poses alone."""
        pose_age = min(REFUSED_POSE_AGE, limits.pose_age) if self.refuses_poses else limits.pose_age
        return self._why("pose", self._clock.age(local), pose_age)

    def _why_scan(self, local: float, limit: float) -> str:
        received = max((at for _, at in self._unplaced), default=-math.inf)
        return self._trust.why_not(local) or self._why("scan", local - max(received, self._scan_received), limit)

    def _why(self, kind: str, age: float, limit: float) -> str:
        reason = why_stale(kind, age, limit)
        return f"{kind} refused: {self._refused[kind]}" if reason and kind in self._refused else reason

    def now(self, local: float) -> float | None:
        """The time on the poses' clock [s]; None before the first pose."""
        return self._clock.now(local)

    @property
    def scan_stamp(self) -> float | None:
        """Stamp of the newest scan that was not refused [s]; None before the first."""
        if self._unplaced:
            return self._unplaced[-1][0].stamp
        return self._scans[-1].stamp if self._scans else None

    @property
    def newest_stamp(self) -> float:
        """Stamp of the newest pose [s], 0 before the first; no plan made so far has a later one."""
        return 0.0 if self.state is None else self.state.stamp

    def newest_placed(self, after: float = -math.inf, until: float = math.inf) -> tuple[Scan, State] | None:
        """The newest scan whose poses are known, and the pose at its stamp, which is in (after, until] [s]."""
        for scan in reversed(self._scans):
            state = self._poses.at(scan.stamp) if after < scan.stamp <= until else None
            if state is not None:
                return scan, state
        return None

    def pose_at(self, stamp: float) -> State | None:
        """The pose at this stamp [s]; None where it is not known, as before a relocation."""
        return self._poses.at(stamp)
