"""Scans received during a check, and the LIDAR's mounting pose from them."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from sensor_msgs.msg import LaserScan

from collplan_core.calibration.lidar_fit import at_rest, fit_mount
from collplan_core.calibration.mocap_offset import BodyOffset
from collplan_core.scan import Scan, ScanError
from collplan_core.sensing.mocap_body import without_offset
from collplan_core.sensing.pose_filter import PoseSample
from collplan_core.sensing.scan_filters import used_scan
from collplan_ros.bringup.check_findings import GOOD, WRONG, Finding, lidar_finding, scans_finding
from collplan_ros.bringup.listener import Listener
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.messages.qos import SENSOR_DATA
from collplan_ros.messages.reading import scan_from_message


class LidarScans:
    """Subscribes to scans of any frame, and finds their sensor's mounting pose on the robot."""

    def __init__(self, listener: Listener, preparation: Preparation) -> None:
        """Listens through bringup's node; `preparation` has the world and how scans are read."""
        self._now = listener.local_time
        self._settings = preparation.settings
        self._world = preparation.world
        self._frame = ""
        self._refused = ""
        self._scans: list[Scan] = []
        self._received: list[float] = []
        listener.node.create_subscription(LaserScan, "scan", self._take, SENSOR_DATA)

    def _take(self, message: LaserScan) -> None:
        # which way round its angles count is to be found
        taken = replace(self._settings.scan, frame=message.header.frame_id, mirrored=False)
        try:
            self._scans.append(used_scan(scan_from_message(message, self._settings.frames.base, taken), taken))
        except ScanError as error:
            self._refused = str(error)
            return
        self._received.append(self._now())
        self._frame = str(message.header.frame_id)

    def coming(self, body: Sequence[PoseSample], received: Sequence[float]) -> Finding:
        """Returns the finding on whether scans arrive, and with stamps of the poses' clock.

        Args:
            body: poses of the measured body, in order of receipt.
            received: time of receipt of each, on the local clock [s].
        """
        before = [bisect_right(received, at) - 1 for at in self._received]
        late = [body[k].stamp - scan.stamp for k, scan in zip(before, self._scans, strict=True) if k >= 0]
        if late:
            return scans_finding(float(np.median(late)), self._settings.limits)
        refused = f", refused: {self._refused}" if self._refused else ""
        return Finding(WRONG, f"no scan came (best effort){refused}")

    def find(self, body: Sequence[PoseSample], offset: BodyOffset) -> tuple[Finding, dict[str, object]]:
        """Returns the finding on the scans and the parameters found, none if wrong or uncertain; call after `coming`.

        Args:
            body: poses of the measured body during the check, in order.
            offset: place of the measured body on the robot.
        """
        robot = [without_offset(pose, offset.x, offset.y, offset.yaw) for pose in body]
        resting = at_rest(self._scans, robot)
        if not resting:
            newest = max(scan.stamp for scan in self._scans)
            stamps = f"the newest scan is of {newest:.2f} s, the newest pose of {body[-1].stamp:.2f} s"
            return Finding(WRONG, f"no scan of the robot at rest: {stamps}"), {}
        fit = fit_mount(resting, self._world)
        finding = lidar_finding(fit, len(resting))
        if fit is None or finding.verdict != GOOD:
            return finding, {}
        mount = fit.mount
        found = {f"scan.offset_{key}": round(getattr(mount, key), 5) for key in ("x", "y", "yaw")}
        frame = "" if self._frame == self._settings.frames.base else self._frame
        return finding, {**found, "scan.mirrored": mount.mirrored, "scan.frame": frame}
