"""Check of the poses and scans that planner or controller received, and counts of what is refused."""

import math
from collections import Counter

from collplan_core.ages import PosesClock
from collplan_core.control.permission import why_stale
from collplan_core.loop.sensed_scans import Judged, SensedScans
from collplan_core.parameters import Limits, Settings
from collplan_core.scan import Scan, ScanError
from collplan_core.scans.plausibility import REPEATED
from collplan_core.state import State


class Refusals:
    """Refused inputs: counts by kind, and the newest reason."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self.newest = ""  # reason of the newest refusal; empty before the first

    def add(self, kind: str, reason: str) -> None:
        """Counts an input of this kind that was refused for this reason."""
        self._counts[kind] += 1
        self.newest = reason

    def __getitem__(self, kind: str) -> int:
        return self._counts[kind]

    @property
    def values(self) -> dict[str, object]:
        """Values of a `Health`: `refused_<kind>` and `last_refusal`; empty before the first refusal."""
        counts: dict[str, object] = {f"refused_{kind}": count for kind, count in sorted(self._counts.items())}
        return {**counts, "last_refusal": self.newest} if counts else {}


REJECTED_IN_A_ROW = 2
"""Number of scans rejected in a row that stops the robot; a single one is left out."""
PAUSE = 0.5
"""Time for which the robot stands after the last refusal, the first time [s]."""
RECENT = 10.0
"""Time after a stop within which another stop lasts twice as long [s]: a robot at rest sees nothing of a delay, and
would drive on into the next one."""


class ScanGate:
    """Counts rejected and accepted scans, each at `local` [s, local clock], and decides whether to stand still."""

    def __init__(self) -> None:
        """Starts with an open gate."""
        self._rejected_in_a_row = 0
        self._reason = ""
        self._stopped_at = float("-inf")
        self._pause = 0.0

    def reject(self, reason: str, local: float) -> None:
        """Counts a rejected scan."""
        self._rejected_in_a_row += 1
        self._reason = reason
        if self._rejected_in_a_row == REJECTED_IN_A_ROW:
            again = local - self._stopped_at <= self._pause + RECENT
            self._pause = 2.0 * self._pause if again else PAUSE
        if self._rejected_in_a_row >= REJECTED_IN_A_ROW:
            self._stopped_at = local

    def accept(self) -> None:
        """Counts an accepted scan."""
        self._rejected_in_a_row = 0

    @property
    def is_closed(self) -> bool:
        """True where the newest scans were rejected."""
        return self._rejected_in_a_row >= REJECTED_IN_A_ROW

    def why_not(self, local: float) -> str:
        """Returns the reason why scans must not be used for driving now; "" where they may."""
        standing = self.is_closed or local - self._stopped_at < self._pause
        return _refused("scan", self._reason) if standing else ""


def _refused(kind: str, reason: str) -> str:
    """The reason why the robot stands after so many refused poses or scans (`kind`)."""
    return f"{kind} refused: {reason}; inspect on this run's folder finds settings that are wrong"


REFUSED_POSE_AGE = 0.05
"""Oldest pose acted on while newer ones come and are refused [s]; one of them alone stops nothing at 100 Hz."""


class InputGate:
    """The age of poses and scans since local receipt [s], and counts of refused ones."""

    def __init__(self, sensed: SensedScans, refusals: Refusals) -> None:
        """Counts refused inputs in `refusals`."""
        self.sensed = sensed  # the poses and scans
        self._refusals = refusals
        self._scan_received = -math.inf
        self._refused: dict[str, str] = {}
        self._gate = ScanGate()
        self._clock = PosesClock()
        self.state: State | None = None  # newest pose; None before the first

    def take_pose(self, state: State, local: float, settings: Settings) -> bool:
        """Adds a pose received at `local` [s, local clock]; returns whether it joins the one before, as the first does.

        One that is too far from it in space or time begins anew: what was received before is dropped.
        """
        joins, judged = self.sensed.take_pose(state, local, settings)
        if not joins:
            self._refusals.add("pose_break", f"the poses begin anew at {state.stamp:.3f}")
        self._clock.received(state.stamp, local, joins)
        self._refused.pop("pose", None)
        self.state = state
        self._count(judged)
        return joins

    def take_scan(self, scan: Scan, local: float, settings: Settings) -> None:
        """Adds a scan received at `local` [s, local clock]."""
        reason = self._why_late_or_early(scan, local, settings.limits)
        if not reason:
            try:
                self._count(self.sensed.take_scan(scan, local, settings))
            except ScanError as error:
                reason = str(error)
        if reason:
            self._refusals.add("scan", reason)
            self.refuse("scan", reason)

    def _why_late_or_early(self, scan: Scan, local: float, limits: Limits) -> str:
        """Returns why a scan takes too long, or comes too late or too early for its pose; "" where it is in time."""
        if scan.sweep > limits.scan_age:
            found = f"time_increment or scan_time: {len(scan.ranges)} beams take {scan.sweep:.2g} s"
            return f"{found}, expected at most limits.scan_age {limits.scan_age:g} s: scan.instant?"
        now = self._clock.now(local)
        late = 0.0 if now is None else now - scan.stamp
        if late > limits.scan_age:
            return f"it comes {late:.2f} s after its stamp, limit {limits.scan_age:.2f} s"
        early = -late - self._clock.late  # a scan is not early because the newest pose is late
        if early > limits.pose_age:
            return f"it comes {early:.2f} s before its stamp, limit {limits.pose_age:.2f} s"
        return ""

    def _count(self, judged: Judged) -> None:
        for reason, local in judged:
            if reason.startswith(REPEATED):
                self.refuse("scan", reason)
            elif reason:
                self._refusals.add("scan", reason)
                self._gate.reject(reason, local)
                self.refuse("scan", reason)
            else:
                self._scan_received = local
                self._gate.accept()
                self._refused.pop("scan", None)

    def refuse(self, kind: str, reason: str) -> None:
        """Notes that the newest pose or scan (`kind` "pose" or "scan") cannot be used, and why."""
        self._refused[kind] = reason

    @property
    def refuses_poses(self) -> bool:
        """True where the newest pose could not be used."""
        return "pose" in self._refused

    def forget_scans(self) -> None:
        """Uses scans again at once; where they are refused, the next one is accepted, whatever it shows.

        For a world that has changed. The person who requests it has checked robot and scan.
        """
        if self._gate.is_closed:
            self.sensed.forget()
            self._refused.pop("scan", None)
        self._gate = ScanGate()

    def why_lost(self, local: float, limits: Limits) -> str:
        """Returns why poses or scans that were there are unusable now; "" where they are usable, or one never came."""
        both_came = self.state is not None and self._scan_received > -math.inf
        return self.why_stale(local, limits) if both_came else ""

    def why_stale(self, local: float, limits: Limits) -> str:
        """Returns why poses or scans are unusable: none yet, too old, or the last ones refused; "" if usable."""
        return self.why_no_pose(local, limits) or self._why_scan(local, limits.scan_age)

    def why_no_pose(self, local: float, limits: Limits) -> str:
        """Returns the same reason, of poses alone."""
        pose_age = min(REFUSED_POSE_AGE, limits.pose_age) if self.refuses_poses else limits.pose_age
        return self._why("pose", self._clock.age(local), pose_age)

    def _why_scan(self, local: float, limit: float) -> str:
        received = max(self.sensed.unplaced_received, self._scan_received)
        return self._gate.why_not(local) or self._why("scan", local - received, limit)

    def _why(self, kind: str, age: float, limit: float) -> str:
        reason = why_stale(kind, age, limit)
        return _refused(kind, self._refused[kind]) if reason and kind in self._refused else reason

    def now(self, local: float) -> float | None:
        """The time on the poses' clock [s]; None before the first pose."""
        return self._clock.now(local)

    @property
    def newest_stamp(self) -> float:
        """Stamp of the newest pose [s], 0 before the first; no plan made so far has a later one."""
        return 0.0 if self.state is None else self.state.stamp
