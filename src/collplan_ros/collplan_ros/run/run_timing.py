"""Timing of a graph in a run: simulated time against the wall clock, and its longest gap."""

import numpy as np

from collplan_core.evaluation.machine import Timing
from collplan_ros.run.run_log import RunLog


def timing_of(log: RunLog) -> Timing:
    """Timing of a run, from its first command to move to its end.

    The gap is the longest time between two commands, which their sender's middleware stamps. Where simulated time waits
    for the nodes there is none.
    """
    begin = log.time_zero
    poses = [pose for pose in log.poses if begin is not None and pose.stamp >= begin]
    simulated_time = poses[-1].stamp - poses[0].stamp if poses else 0.0
    passed = poses[-1].sent - poses[0].sent if poses else 0.0
    factor = simulated_time / passed if log.simulated and passed > 0.0 else None
    if log.pace == 0.0:
        return Timing(factor)
    sent = [command.sent for command in log.commands if begin is not None and command.stamp >= begin]
    return Timing(factor, float(np.diff(sent).max(initial=0.0)))
