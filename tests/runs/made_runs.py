"""Logs of runs made by hand, and what a recorder would have written of them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from collplan_ros.run.record_file import RecordFile
from collplan_ros.run.record_reading import Told

from collplan_core.parameters import Settings
from collplan_core.plan import Contacts
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_core.worlds.raycast import simulate_scan
from collplan_ros.run.run_log import (
    DetectedImpactRecord,
    ImpactRecord,
    PlanRow,
    PoseRow,
    RunLog,
    SentCommand,
    SentManeuver,
)

EPOCH = 1.7e9
AHEAD = EPOCH - 77.0
"""Of the poses' clock before the clock of sending [s]."""
THOUGHT = 0.03
"""From the stamp of a plan to when it is sent [s]."""
GOAL = np.array([0.0, 0.1])
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


def detected_only(log: RunLog) -> RunLog:
    """The run as a real robot leaves it, with its hit at HIT_AT detected in the poses."""
    hit = DetectedImpactRecord(EPOCH + HIT_AT - 0.003, WALL, 0.1, -1.0, 0.0)
    return replace(log, truth=[], true_impacts=[], detected_impacts=[hit])


def write_record(path: Path, log: RunLog, goal: np.ndarray = GOAL, told: Sequence[Told] = ()) -> None:
    """Writes what a recorder would have written of this run, without its end."""
    file = RecordFile(path)
    file.write("run", {"simulated": True, "goal": goal.tolist(), "wall_clock_ahead": AHEAD})
    rows = [(row.sent, "pose", row) for row in log.poses] + [(row.sent, "truth", row) for row in log.truth]
    rows += [(row.sent, "command", row) for row in log.sent_commands]
    rows += [(row.sent, "maneuver", row) for row in log.sent_maneuvers]
    rows += [(row.sent, row.kind, (row.sent, *row.entries)) for row in told]
    rows += [(i.stamp - AHEAD, "true_impact", (i.stamp - AHEAD, *i)) for i in log.true_impacts]
    for stamp, each in log.contacts.items():
        vectors = each.points.tolist(), each.velocities_after.tolist()
        rows.append((stamp - AHEAD, "contacts", (stamp - AHEAD, stamp, each.times.tolist(), *vectors)))
    for plan in log.plans:
        sent = plan.stamp - AHEAD + THOUGHT
        rows.append((sent, "plan", (sent, plan.stamp, plan.times.tolist(), plan.positions.tolist())))
    for scan in log.scans:
        sent = scan.stamp - AHEAD
        limits = scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max, scan.time_increment
        rows.append((sent, "scan", (sent, scan.stamp, *limits, scan.ranges.tolist())))
    for _, kind, entries in sorted(rows, key=lambda row: row[0]):
        file.write(kind, *entries)
    file.flush()
