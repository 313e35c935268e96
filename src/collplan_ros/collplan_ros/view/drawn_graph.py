"""Turns the messages of a robot's graph into parts of frames: of a live graph, and of a recording read without ROS."""

import math
from ast import literal_eval
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from collplan_core.evaluation.run_end import Timing, machine_verdict, pace_words
from collplan_core.goal import ACTIVE, NO_GOAL
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.poses.pose_history import state_at
from collplan_core.scans.placing import placed_among
from collplan_core.state import State
from collplan_ros.messages import cloud_reading as clouds
from collplan_ros.messages.raw_reading import plan_from_path, state_from_bytes
from collplan_ros.messages.reading import GOAL_STATUS, goal_from_message, movers_from_markers, scan_from_message
from collplan_ros.messages.status_values import real_time_factor, values_of
from collplan_ros.node_kit.node_names import is_in
from collplan_ros.view import scene
from collplan_ros.view.frames import Changes

KEPT = 1.5
"""Time for which poses are kept, to find the one at a scan's stamp [s]."""
STEP_BACK = 0.5
"""A pose that is so much before the newest begins another time, as after a restart [s]."""
QUIET = 0.25
"""Time without poses after which that of the frames goes on without them [s]: those of a slow simulation are rare."""
MEMORY_EVERY = 5
"""One in so many planner/seen messages updates the memory shown: it is their largest part and changes least."""
NODES_PERIOD = 0.5
"""Time between two looks at which nodes are silent [s]."""
MOST_NODES = 50
"""Nodes shown: so many belong to no robot."""
LONGEST_PERIOD = 2.0
"""A longer time between two commands is a pause, not a period [s]."""
RECENT = 10.0
"""Age beyond which figures of the graph's timing are no longer shown [s]."""
PARTS = dict(zip(clouds.LAYERS, ("free", *clouds.LAYERS[1:]), strict=True))
"""Parts by layer of planner/seen."""
WARN = 1
"""DiagnosticStatus.WARN: level at which the controller reports that the robot stands though a goal is active."""


class Stamps:
    """Shows the stamps of messages as they are, and the time of now [s], by which a silent node is silent."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self.now = clock

    def of_pose(self, stamp: float, sent: float) -> float:
        """Time shown [s] of the next pose, from its stamp [s] and when it was sent [s]."""
        return stamp

    def of(self, stamp: float) -> float:
        """Time shown [s] of the stamp [s] of another message."""
        return stamp


class DrawnGraph:
    """Takes the messages of one graph, and puts the parts that they make into the next frame."""

    def __init__(self, settings: Settings, changes: Changes, namespace: str, stamps: Stamps) -> None:
        """Puts parts into `changes`."""
        self.goal: np.ndarray | None = None  # the newest given, (2,) [m]
        self.impacts = scene.ShownImpacts()
        self.robot = ""  # full name of the node that publishes robot/state
        self.reports: dict[str, scene.NodeReport] = {}  # the newest of each node of this namespace, by full name
        # what nodes tell of theirs, latched and whenever one changes: by node, the newest told last, and by name
        self.parameters: dict[str, scene.Values] = {}
        # what takes a message and its time of sending [s], by topic
        self.takers: dict[str, Callable[[Any, float], None]] = {
            "mocap/odom": self._take_pose,
            "scan": self._take_scan,
            "planner/trajectory": self._take_trajectory,
            "plan": self._take_path,
            "planner/seen": self._take_seen,
            "planner/compared": self._take_compared,
            "planner/costs": self._take_costs,
            "goal_pose": self._take_goal,
            "goal_status": self._take_status,
            "ground_truth/movers": lambda message, _: self._put_movers("movers", message),
            "movers": lambda message, _: self._put_movers("found", message),
            "impact/contact": self._take_impact,
            "controller/state": self._take_doing,
            "controller/drive": self._take_drive,
            "robot/state": self._take_hold,
            "cmd_vel": self._take_command,
            "/diagnostics": self._take_health,
            "shared_constants": self._take_parameters,
        }
        self._frames, self._scan = settings.frames, settings.scan
        self._changes, self._namespace, self._stamps = changes, namespace, stamps
        self._full_speed, self._command_age = settings.simulator.speed_factor, settings.limits.command_age
        # simulated seconds in a second, and times between two commands [s], each with when it was told
        self._factors: deque[tuple[float, float]] = deque()
        self._gaps: deque[tuple[float, float]] = deque()
        self._states: deque[State] = deque()
        self._fresh: list[State] = []
        self._robot: scene.Part = None
        self._seen = 0
        self._told: float | None = None
        self._commanded = math.nan
        self._periods: list[float] = []
        self._time = 0.0
        self._posed: float | None = None
        self._came = stamps.now()
        self._status = NO_GOAL
        self._told_nodes = -math.inf

    @property
    def heard(self) -> list[str]:
        """Full names of the nodes that are not silent."""
        now = self._stamps.now()
        return [name for name, report in self.reports.items() if now - report.came <= scene.SILENT_AFTER]

    def put_frame(self) -> float:
        """Puts what was gathered for a frame into the changes; returns the time of the frame [s]."""
        now = self._stamps.now()
        self._put_robot(now)
        if self._periods:
            self._changes.put("periods", [round(1e3 * period, 1) for period in self._periods])
            self._periods = []
        if now - self._told_nodes >= NODES_PERIOD:
            self._told_nodes = now
            self._changes.put("nodes", scene.nodes(self.reports.values(), now))
        return scene.time_of(self._time)

    def put_machine(self) -> None:
        """Puts the speed of simulated time in the last seconds, and whether the machine is fast enough for a robot."""
        oldest = self._stamps.now() - RECENT
        for rows in (self._factors, self._gaps):
            while rows and rows[0][0] < oldest:
                rows.popleft()
        factors = [factor for _, factor in self._factors]
        longest = max((gap for _, gap in self._gaps), default=0.0)
        timing = Timing(sum(factors) / len(factors) if factors else None, longest)
        verdict = machine_verdict(timing, self._full_speed, self._command_age)
        self._changes.put("machine", {"pace": pace_words(factors[-1] if factors else None), "verdict": verdict})

    def put_goal(self) -> None:
        """Puts the goal and its status."""
        at = None if self.goal is None else scene.milli(self.goal)
        self._changes.put("goal", {"at": at, "status": self._status})

    def put_impacts(self) -> None:
        """Puts the impacts so far."""
        self._changes.put("impacts", self.impacts.part)
        self._changes.put("counts", self.impacts.counts)

    def _take_pose(self, raw: bytes, sent: float) -> None:
        state = state_from_bytes(raw, self._frames.map, self._frames.base)
        state = replace(state, stamp=self._stamps.of_pose(state.stamp, sent))
        self._robot = scene.robot(state)
        if self._states and state.stamp < self._states[-1].stamp - STEP_BACK:
            # parts of an earlier time, as before a restart of the robot, hold no more
            self._states.clear()
            self._fresh.clear()
            self.impacts = scene.ShownImpacts()
            self.put_impacts()
        self._states.append(state)
        self._fresh.append(state)
        while self._states[0].stamp < state.stamp - KEPT:
            self._states.popleft()

    def _put_robot(self, now: float) -> None:
        before = -math.inf if self._posed is None else self._time
        if self._fresh:
            *between, newest = self._fresh
            self._fresh = []
            self._time = self._posed = newest.stamp
            self._came = now
            self._changes.put("robot", self._robot)
            if between:
                self._changes.put("trail", scene.trail(between, newest.stamp))
        elif now - self._came > QUIET:
            # a silent node must be shown as silent
            self._time = (self._posed or 0.0) + now - self._came
        if 0.0 < before - self._time < STEP_BACK:
            self._time = before

    def _take_scan(self, message: Any, _: float) -> None:
        scan = scan_from_message(message, self._frames.base, self._scan)
        if not self._states:
            return
        scan = replace(scan, stamp=self._stamps.of(scan.stamp))
        state = state_at(self._states, scan.stamp)
        self._changes.put("scan", scene.scan(placed_among(scan, state, self._states, self._scan), state))

    def _take_trajectory(self, message: Any, _: float) -> None:
        plan = clouds.plan_from_message(message, self._frames.map)
        self._told = plan.stamp
        self.impacts.planned(plan)
        self._put_plan(plan)

    def _take_path(self, raw: bytes, _: float) -> None:
        plan = plan_from_path(raw, self._frames.map)
        if plan.stamp != self._told:
            self._put_plan(plan)

    def _put_plan(self, plan: Plan) -> None:
        part = scene.plan(plan.stamp, plan.times, plan.positions, plan.contacts)
        self._changes.put("plan", part | {"stamp": scene.time_of(self._stamps.of(plan.stamp))})

    def _take_seen(self, message: Any, _: float) -> None:
        with_memory = self._seen % MEMORY_EVERY == 0
        for layer, points in clouds.seen_from_message(message, self._frames.map).items():
            if with_memory or layer not in (clouds.REMEMBERED, clouds.INFERRED):
                self._changes.put(PARTS[layer], scene.milli(points))
        self._seen += 1

    def _take_compared(self, message: Any, _: float) -> None:
        found = clouds.compared_from_message(message, self._frames.map)
        self._changes.put("candidates", scene.candidates(found.rows, found.terms))
        self._changes.put("rollouts", scene.rollouts(found.paths, found.costs))

    def _take_costs(self, message: Any, _: float) -> None:
        for status in message.status:
            self._changes.put("costs", scene.costs(values_of(status)))

    def _put_movers(self, part: str, message: Any) -> None:
        stamp, rows = movers_from_markers(message, self._frames.map)
        self._changes.put(part, scene.movers(self._stamps.of(stamp), rows))

    def _take_goal(self, message: Any, _: float) -> None:
        self.goal = goal_from_message(message, self._frames.map)
        self.put_goal()

    def _take_status(self, message: Any, _: float) -> None:
        self._status = GOAL_STATUS.get(int(message.status), NO_GOAL)
        self.put_goal()
        if self._status not in ACTIVE:
            self._changes.put("plan", None)
            for name in ("free", "frontiers", "predicted", "rollouts"):
                self._changes.put(name, [])
            self._changes.put("candidates", scene.candidates(np.zeros((0, 4)), {}))

    def _take_impact(self, message: Any, _: float) -> None:
        self.impacts.happened(clouds.impact_from_cloud(message, self._frames.map))
        self.put_impacts()

    def _take_hold(self, message: Any, _: float) -> None:
        self.robot = str(message.name)
        self._changes.put("hold", {"state": values_of(message).get("state", ""), "message": str(message.message)})

    def _take_doing(self, message: Any, _: float) -> None:
        values = values_of(message)
        told = {name: values.get(name, "") for name in ("maneuver", "reason")}
        self._changes.put("doing", told | {"warn": _level(message) >= WARN})

    def _take_drive(self, message: Any, _: float) -> None:
        self._changes.put("drive", {"message": str(message.message), "warn": _level(message) >= WARN})

    def _take_command(self, _: Any, sent: float) -> None:
        if 0.0 < sent - self._commanded < LONGEST_PERIOD:
            self._periods.append(sent - self._commanded)
            self._gaps.append((self._stamps.now(), sent - self._commanded))
        self._commanded = sent

    def _take_health(self, message: Any, _: float) -> None:
        for status in message.status:
            told = str(status.name), _level(status), str(status.message), values_of(status)
            report = scene.NodeReport(*told, self._stamps.now())
            fits = report.name in self.reports or len(self.reports) < MOST_NODES
            if is_in(self._namespace, report.name) and fits:
                self.reports[report.name] = report
                if (factor := real_time_factor(report.values)) is not None:
                    self._factors.append((report.came, factor))

    def _take_parameters(self, message: Any, _: float) -> None:
        """Takes what a node tells; a value that is none of Python's is left out."""
        name, told = str(message.name), dict[str, object]()
        if is_in(self._namespace, name):
            for key, text in values_of(message).items():
                with suppress(ValueError, SyntaxError):
                    told[key] = literal_eval(text)
            self.parameters.pop(name, None)
            self.parameters[name] = told


def _level(status: Any) -> int:
    """Returns the level of a status: a `byte` is bytes in rclpy, and a number in other readers."""
    level = status.level
    return level[0] if isinstance(level, bytes) else int(level)
