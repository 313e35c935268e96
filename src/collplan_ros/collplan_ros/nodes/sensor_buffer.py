"""The recent poses and scans that a node received, decoded and checked; shared by planner and controller."""

import math
from collections import deque

from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from collplan_core.control.permission import is_relocated
from collplan_core.parameters import Settings
from collplan_core.scan import Scan, ScanError
from collplan_core.sensing.pose_history import PoseHistory
from collplan_core.state import State
from collplan_ros.messages.conversions import MessageError, scan_from_message, state_from_odometry
from collplan_ros.node_kit.clock import PosesClock
from collplan_ros.node_kit.refusals import Refusals

REFUSED, ACCEPTED, RELOCATED = "refused", "accepted", "relocated"
"""Verdicts on a pose: invalid; continues the earlier ones; valid, but too far from them in space or time."""


class SensorBuffer:
    """The recent poses and scans, and their age since local receipt [s]. A relocated pose clears both.

    Attributes:
        state: newest pose; None before the first.
    """

    def __init__(self, span: float, refusals: Refusals) -> None:
        """Keeps poses and scans for `span` [s] by their stamps, and counts refused ones in `refusals`."""
        self._span = span
        self._refusals = refusals
        self._poses = PoseHistory(span)
        self._scans: deque[Scan] = deque()
        self._scan_received = -math.inf
        self._clock = PosesClock()
        self.state: State | None = None

    def take_pose(self, message: Odometry, local: float, settings: Settings) -> str:
        """Adds a pose received at `local` [s, local clock]; returns REFUSED, ACCEPTED or RELOCATED."""
        try:
            state = state_from_odometry(message, settings.frames.map, settings.frames.base)
        except MessageError as error:
            self._refusals.add("pose", str(error))
            return REFUSED
        margin = settings.mocap.leap_margin
        relocated = self.state is not None and is_relocated(self.state, state, settings.robot, settings.limits, margin)
        if relocated:
            self._refusals.add("pose_break", f"the poses begin anew at {state.stamp:.3f}")
            self._poses.clear()
            self._scans.clear()
        self._poses.add(state)
        self._clock.received(state.stamp, local)
        self.state = state
        return RELOCATED if relocated else ACCEPTED

    def take_scan(self, message: LaserScan, local: float, settings: Settings) -> bool:
        """Adds a scan received at `local` [s, local clock]; returns whether it was accepted."""
        try:
            scan = scan_from_message(message, settings.frames.base)
        except ScanError as error:
            self._refusals.add("scan", str(error))
            return False
        if self._scans and scan.stamp <= self._scans[-1].stamp:
            self._scans.clear()
        self._scans.append(scan)
        self._scan_received = local
        while self._scans[0].stamp < scan.stamp - self._span:
            self._scans.popleft()
        return True

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
        """Stamp of the newest scan [s]; None before the first."""
        return self._scans[-1].stamp if self._scans else None

    @property
    def newest_stamp(self) -> float:
        """Stamp of the newest pose [s], 0 before the first; no plan made so far has a later one."""
        return 0.0 if self.state is None else self.state.stamp

    def newest_placed(self, after: float) -> tuple[Scan, State] | None:
        """The newest scan with a stamp later than `after` [s] whose pose is known, and that pose."""
        for scan in reversed(self._scans):
            state = self._poses.at(scan.stamp) if scan.stamp > after else None
            if state is not None:
                return scan, state
        return None

    def pose_at(self, stamp: float) -> State | None:
        """The pose at this stamp [s]; None where it is not known, as before a relocation."""
        return self._poses.at(stamp)

    def placed_at(self, stamp: float) -> tuple[Scan, State] | None:
        """The scan with exactly this stamp [s] and the pose at it; None where either is missing."""
        scan = next((scan for scan in self._scans if scan.stamp == stamp), None)
        state = self._poses.at(stamp) if scan is not None else None
        return None if scan is None or state is None else (scan, state)
