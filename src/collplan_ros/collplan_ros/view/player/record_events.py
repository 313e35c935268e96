"""What record.jsonl tells of a run, as parts of frames.

Free space, frontiers and predicted boundaries are not recorded there: they are computed again from each scan and the
pose at its stamp, as the planner does.
"""

import math
from bisect import bisect_right
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from collplan_core.goal import ACTIVE, NO_GOAL
from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.planners import local_mapping_of
from collplan_core.scan import Scan, ScanError
from collplan_core.sensing.beam_poses import placed_among
from collplan_core.state import State
from collplan_ros.runs.run_log import PoseRow, RunLog, states_around
from collplan_ros.view import scene
from collplan_ros.view.impacts import DELIBERATE, FORESEEN, KINDS, MOST, OTHER
from collplan_ros.view.message_parts import parts_without_goal
from collplan_ros.view.player.played_run import PlayedRun
from collplan_ros.view.player.run_frames import Event, Frame

ARROW_LENGTH = 0.15
"""Drawn length of a predicted boundary [m]."""


def beginning(run: PlayedRun) -> Frame:
    """Parts that hold from the first frame on."""
    robot, planner = run.settings.robot, run.settings.planner
    return {
        "about": {
            "robot": scene.SIMULATED if run.record.simulated else scene.REAL,
            "namespace": "/",
            "world": run.world.name,
            "radius": scene.milli([robot.radius])[0],
            "max_speed": scene.milli([robot.max_speed])[0],
            "tolerance": scene.milli([planner.goal_tolerance])[0],
            "spacing": scene.milli([run.settings.remembered.spacing])[0],
        },
        "world": scene.world(run.world),
        "machine": run.machine,
        "goal": _goal(run.record.goal, NO_GOAL),
        "impacts": [],
    }


def record_events(run: PlayedRun) -> Iterator[Event]:
    """What was measured, planned and commanded, and what became of the goal."""
    yield from _scans(run)
    yield from _plans(run)
    yield from _impacts(run)
    yield from _controller(run.record.log)
    yield from _told(run)


def map_events(run: PlayedRun) -> Iterator[Event]:
    """Free space, frontiers and predicted boundaries, computed again."""
    settings = run.settings
    for scan, state in _placed_scans(run):
        seen = build_local_map(scan, state, settings.robot, local_mapping_of(settings))
        yield Event(scan.stamp, "free", scene.milli(seen.border_points))
        yield Event(scan.stamp, "frontiers", scene.milli(seen.segments))
        yield Event(scan.stamp, "predicted", scene.milli(_arrows(seen)))


def state_at(poses: list[PoseRow], stamp: float) -> State:
    """The state at a stamp [s] between poses; the first or the last pose outside them."""
    following = bisect_right(poses, stamp, key=lambda pose: pose.stamp)
    before, after = poses[max(following - 1, 0)], poses[min(following, len(poses) - 1)]
    return scene.between(before.state, after.state, stamp)


def _scans(run: PlayedRun) -> Iterator[Event]:
    for scan, state in _placed_scans(run):
        yield Event(scan.stamp, "scan", scene.scan(scan, state))


def _placed_scans(run: PlayedRun) -> Iterator[tuple[Scan, State]]:
    poses = run.record.log.poses
    for scan in run.record.log.scans[:: run.one_in]:
        state = state_at(poses, scan.stamp)
        try:
            placed = placed_among(scan, state, states_around(poses, scan), run.settings.scan)
        except ScanError:  # nothing of it is used: older records hold such scans
            continue
        yield placed, state


def _plans(run: PlayedRun) -> Iterator[Event]:
    log = run.record.log
    for plan in log.plans:
        contacts = log.contacts.get(plan.stamp)
        # a plan made by hand says no more than when it begins
        came = log.stamp_at(plan.sent) if math.isfinite(plan.sent) else plan.stamp
        part = scene.plan(plan.stamp, plan.times, plan.positions, contacts)
        yield Event(came, "plan", part | {"stamp": scene.time_of(plan.stamp - run.zero)})


def _impacts(run: PlayedRun) -> Iterator[Event]:
    found: list[scene.Part] = []
    counts = dict.fromkeys(KINDS, 0)
    for k, time in enumerate(run.impacts.times.tolist()):
        impact = _impact(run, k)
        found = [*found, impact][-MOST:]
        counts = {**counts, impact["kind"]: counts[impact["kind"]] + 1}
        yield Event(time, "impacts", found)
        yield Event(time, "counts", counts)


def _impact(run: PlayedRun, k: int) -> scene.Part:
    impacts, time = run.impacts, float(run.impacts.times[k])
    foreseen = FORESEEN if impacts.foreseen[k] else OTHER
    kind = DELIBERATE if impacts.deliberate[k] else foreseen
    place, normal, speed = impacts.points[k], impacts.normals[k], float(impacts.speeds[k])
    known = bool(np.isfinite([*place, *normal, speed]).all())
    # in a world without surfaces only the robot's own place is known
    return {
        "t": scene.time_of(time - run.zero),
        "at": scene.milli(place if known else state_at(run.record.log.poses, time).position),
        "normal": scene.milli(normal) if known else [0, 0],
        "kind": kind,
        "speed": scene.milli([speed])[0] if known else None,
    }


def _controller(log: RunLog) -> Iterator[Event]:
    """Maneuvers, and the time from each command to the next."""
    for maneuver in log.sent_maneuvers:
        doing = {"maneuver": maneuver.name, "activity": "", "reason": "", "warn": False}
        yield Event(log.stamp_at(maneuver.sent), "doing", doing)
    for before, after in pairwise(log.sent_commands):
        yield Event(log.stamp_at(after.sent), "periods", [round(1e3 * (after.sent - before.sent), 2)])


def _told(run: PlayedRun) -> Iterator[Event]:
    """What the nodes told of goal, planning and the robot's own state."""
    log, target, status = run.record.log, run.record.goal, NO_GOAL
    for told in run.record.told:
        at = log.stamp_at(told.sent)
        if told.kind == "target":
            target = np.array(told.entries, dtype=float)
            yield Event(at, "goal", _goal(target, status))
        elif told.kind == "goal":
            (status,) = told.entries
            yield Event(at, "goal", _goal(target, status))
            if status not in ACTIVE:
                yield from (Event(at, *part) for part in parts_without_goal())
        elif told.kind == "costs":
            figures = {name: str(value) for name, value in told.entries[0].items()}
            yield Event(at, "costs", scene.costs({"strategy": run.settings.planner.strategy, **figures}))
        elif told.kind == "robot":
            state, message = told.entries
            yield Event(at, "hold", {"state": state, "message": message})


def _goal(target: np.ndarray, status: str) -> scene.Part:
    return scene.goal(target if np.isfinite(target).all() else None, status)


def _arrows(seen: LocalMap) -> np.ndarray:
    """(2 e, 2) origin and tip of each predicted boundary [m]."""
    origins, tangents = seen.predicted[:, :2], seen.predicted[:, 2:]
    return np.stack([origins, origins + ARROW_LENGTH * tangents], axis=1).reshape(-1, 2)
