"""The poses and scans that a node has received, as planner and controller keep them."""

import math
from collections import deque

from collplan_core.params import Limits, Robot
from collplan_core.permission import is_relocated
from collplan_core.pose_history import PoseHistory
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_ros.clock import PosesClock


class Sensed:
    """The last poses and scans, and how old they are by local receipt [s]. Both are forgotten where the poses break."""

    def __init__(self, span: float) -> None:
        """Keeps `span` [s] of both, by their stamps."""
        self._span = span
        self._poses = PoseHistory(span)
        self._scans: deque[Scan] = deque()
        self._scan_received = -math.inf
        self._clock = PosesClock()
        self.state: State | None = None

    def add_pose(self, state: State, local: float, robot: Robot, limits: Limits) -> bool:
        """Takes a pose received at `local` [s, local clock]; whether it does not join the one before."""
        relocated = self.state is not None and is_relocated(self.state, state, robot, limits)
        if relocated:
            self._poses.clear()
            self._scans.clear()
        self._poses.add(state)
        self._clock.received(state.stamp, local)
        self.state = state
        return relocated

    def add_scan(self, scan: Scan, local: float) -> None:
        """Takes a scan received at `local` [s, local clock]."""
        if self._scans and scan.stamp <= self._scans[-1].stamp:
            self._scans.clear()
        self._scans.append(scan)
        self._scan_received = local
        while self._scans[0].stamp < scan.stamp - self._span:
            self._scans.popleft()

    def now(self, local: float) -> float | None:
        """The time on the poses' clock [s]; None before the first pose."""
        return self._clock.now(local)

    def pose_age(self, local: float) -> float:
        """Local time since the newest pose was received [s]; infinite before the first."""
        return self._clock.age(local)

    def scan_age(self, local: float) -> float:
        """Local time since the newest scan was received [s]; infinite before the first."""
        return local - self._scan_received

    @property
    def scan_stamp(self) -> float | None:
        """Stamp of the newest scan [s]."""
        return self._scans[-1].stamp if self._scans else None

    @property
    def newest_stamp(self) -> float:
        """Stamp of the newest scan [s], or of the newest pose where there is no scan, or 0."""
        if self._scans:
            return self._scans[-1].stamp
        return 0.0 if self.state is None else self.state.stamp

    def newest_placed(self, after: float) -> tuple[Scan, State] | None:
        """The newest scan with a stamp later than `after` [s] whose pose is known, and that pose."""
        for scan in reversed(self._scans):
            state = self._poses.at(scan.stamp) if scan.stamp > after else None
            if state is not None:
                return scan, state
        return None

    def placed_at(self, stamp: float) -> tuple[Scan, State] | None:
        """The scan with exactly this stamp [s], and the pose there."""
        scan = next((scan for scan in self._scans if scan.stamp == stamp), None)
        state = self._poses.at(stamp) if scan is not None else None
        return None if scan is None or state is None else (scan, state)
