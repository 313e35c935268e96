"""Logs of runs made by hand."""

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.plan import Contacts
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_core.worlds.raycast import simulate_scan
from collplan_ros.runs.run_log import ImpactRecord, PlanRow, PoseRow, RunLog, SentCommand, SentManeuver

EPOCH = 1.7e9
WALL = 1.0
RADIUS = Settings().robot.radius
WINDOW = Settings().mocap.velocity_window
HIT_AT = 1.0
SPEED = 0.5


def room() -> World:
    block = np.array([[WALL, -1.0], [2.0, -1.0], [2.0, 1.0], [WALL, 1.0]])
    return World("room", (block,), np.array([[-1.0, 0.5, 0.2]]), (-2.0, -1.5, 2.5, 1.5))


def bouncing_run() -> RunLog:
    """Straight at a wall with SPEED, met at HIT_AT, and back with half of it."""
    log = RunLog(sent_maneuvers=[SentManeuver(77.151, "free_space")])
    for k in range(200):
        t = 0.01 * k
        begin = WALL - RADIUS - SPEED * HIT_AT
        x = begin + SPEED * t if t < HIT_AT else WALL - RADIUS - 0.5 * SPEED * (t - HIT_AT)
        row = PoseRow(EPOCH + t, x, 0.1, 0.0, SPEED if t < HIT_AT else -0.5 * SPEED, 0.0, 77.0 + t)
        log.poses.append(row)
        log.truth.append(row)
        if k % 5 == 0:
            log.sent_commands.append(SentCommand(77.0 + t, 0.3 if t > 0.12 else 0.0, 0.0, 0.0))
            log.scans.append(
                simulate_scan(room(), State(row.stamp, np.array([row.x, row.y]), np.zeros(2), 0.0), Settings().lidar)
            )
        if k % 20 == 0:
            log.plans.append(PlanRow(EPOCH + t, EPOCH + t + np.array([0.0, 1.0]), np.array([[x, 0.1], [x + 0.5, 0.1]])))
            touch = Contacts(np.array([EPOCH + HIT_AT + 0.02]), np.array([[WALL, 0.12]]), np.array([[-0.6, 0.8]]))
            log.contacts[EPOCH + t] = touch if t < HIT_AT else Contacts.none()
            log.costs.append({"planning_time_ms": 1.0 + k, "candidates": 10.0, "candidates_before_pruning": 30.0})
    log.true_impacts.append(ImpactRecord(EPOCH + HIT_AT - 0.003, -1.5 * SPEED, 0.0))
    return log
