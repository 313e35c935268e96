"""Where the robot was at each beam of a scan."""

import numpy as np

from collplan_core.scan import Scan
from collplan_core.sensing.pose_history import PoseHistory


def beam_poses(scan: Scan, poses: PoseHistory) -> np.ndarray | None:
    """(n, 3) x, y [m] and yaw [rad], not wrapped, of the robot at each beam; None without a pose for the stamp.

    Beams later than the newest pose are placed by the velocity at the scan's stamp.
    """
    state = poses.at(scan.stamp)
    if state is None:
        return None
    after = scan.time_increment * np.arange(len(scan.ranges))
    known = poses.at_each(scan.stamp + after) if scan.time_increment > 0.0 else None
    if known is not None:
        return known
    x, y = (state.position[:, np.newaxis] + state.velocity[:, np.newaxis] * after).tolist()
    return np.column_stack([x, y, np.full(len(after), state.yaw)])
