"""Inputs for the loops of planner and controller: a robot at rest in a hall, its poses and scans, and its plans."""

from dataclasses import replace

import numpy as np

from collplan_core.goal import Goal
from collplan_core.loop.decisions import Cycle, Notice
from collplan_core.parameters import Settings
from collplan_core.plan import Contacts, Plan, timed_path
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.worlds import parse_world
from collplan_core.worlds.raycast import simulate_scan

SETTINGS = Settings().with_values({"planner.strategy": "custom"})
"""The strategy that the tests put the straight planner in the place of."""
HALL = parse_world({"name": "hall", "bounds": [-1.0, -0.5, 3.0, 0.5]}, "hall")
AHEAD = np.array([2.0, 0.0])
IDENTITY = bytes(range(16))


def at(stamp: float, x: float = 0.0, y: float = 0.0) -> State:
    return State(stamp, np.array([x, y]), np.zeros(2), 0.0)


def scan_at(state: State) -> Scan:
    return simulate_scan(HALL, state, SETTINGS.lidar)


def see(loop, stamp: float, x: float = 0.0):
    """A pose and a scan of one stamp, received at once; what is decided at the pose."""
    decisions = loop.take_pose(at(stamp, x), stamp)
    loop.take_scan(scan_at(at(stamp, x)), stamp)
    return decisions


def see_until(loop, begin: float, end: float) -> None:
    for stamp in [*np.arange(begin + 0.1, end - 1e-6, 0.1).tolist(), end]:
        if stamp > begin:
            see(loop, stamp)


def straight_plan(stamp: float, end=(1.0, 0.0), duration: float = 2.0) -> Plan:
    share = np.linspace(0.0, 1.0, 21)[:, None]
    velocities = np.tile(np.array(end) / duration, (21, 1))
    plan = timed_path(stamp, stamp + duration * share[:, 0], share * np.array(end), velocities)
    return replace(plan, aim_velocity=np.zeros(2), contacts=Contacts.none())


def cycles(decisions) -> list[Cycle]:
    return [decision for decision in decisions if isinstance(decision, Cycle)]


def statuses(decisions) -> list[str]:
    return [decision.status for decision in decisions if isinstance(decision, Goal)]


def notices(decisions) -> list[tuple[str, str]]:
    return [(decision.level, decision.text) for decision in decisions if isinstance(decision, Notice)]
