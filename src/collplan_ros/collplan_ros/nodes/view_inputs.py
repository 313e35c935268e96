"""Inputs of view_node from the graph while a page is open, turned into parts of frames."""

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry, Path
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan, PointCloud2
from trajectory_msgs.msg import MultiDOFJointTrajectory

from collplan_core.goal import NO_GOAL
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.sensing.lidar_mount import placed_among
from collplan_core.sensing.pose_history import state_at
from collplan_core.state import State
from collplan_ros.messages import qos
from collplan_ros.messages.cloud_reading import LAYERS, REMEMBERED
from collplan_ros.messages.conversions import command_type, goal_from_message
from collplan_ros.messages.plan_trajectory import plan_from_trajectory
from collplan_ros.messages.raw_reading import plan_from_path, state_from_bytes
from collplan_ros.messages.reading import impact_contact_from_message, scan_from_message
from collplan_ros.messages.states import goal_from_status
from collplan_ros.messages.status_values import real_time_factor
from collplan_ros.node_kit.node_names import is_in
from collplan_ros.node_kit.shown_topics import ShownTopics
from collplan_ros.nodes.view_parameters import GraphParameters
from collplan_ros.view import scene
from collplan_ros.view.frames import Changes
from collplan_ros.view.impacts import ShownImpacts
from collplan_ros.view.message_parts import (
    Parts,
    compared_parts,
    costs_parts,
    doing_parts,
    hold_parts,
    parts_without_goal,
    report_of,
    seen_parts,
)
from collplan_ros.view.recent_timing import RecentTiming

POSES = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Every pose of a frame's time and of a short stall; none is waited for."""
COMMANDS = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=20, reliability=ReliabilityPolicy.BEST_EFFORT)
NEWEST = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
KEPT = 1.5
"""Time for which poses are kept, to find those at a scan's stamp and before an impact [s]."""
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

Values = Mapping[str, Any]


class ViewInputs:
    """The topics that the page shows: subscribed between `open` and `close`.

    Attributes:
        goal: the newest goal given, (2,) [m]; subscribed all the time, as it is not repeated.
        robot: full name of the node that publishes robot/state; empty before it has.
        reports: newest health report of each node of this namespace, by full name.
        refused: number of messages that could not be read.
        recent: timing of the graph in the last seconds.
    """

    def __init__(
        self,
        node: Node,
        settings: Settings,
        parameters: GraphParameters,
        changes: Changes,
        clock: Callable[[], float],
    ) -> None:
        """Subscribes in `node` and puts parts into `changes`; `clock` gives the local time [s].

        `parameters` takes what nodes tell of theirs.
        """
        self.goal: np.ndarray | None = None
        self.robot = ""
        self.reports: dict[str, scene.NodeReport] = {}
        self._node = node
        self._settings = settings
        self._frames = settings.frames
        self._changes = changes
        self._clock = clock
        self._namespace = node.get_namespace()
        self._parameters = parameters
        self._always = ShownTopics(node)
        self._always.listen(PoseStamped, "goal_pose", self._take_goal, qos.EVENT)
        self._watched = ShownTopics(node)
        self._reset()

    def _reset(self) -> None:
        self._impacts = ShownImpacts()
        self._states: deque[State] = deque()
        self._fresh: list[State] = []
        self._robot: scene.Part = None
        self._told: float | None = None
        self._commanded = math.nan
        self._periods: list[float] = []
        self.recent = RecentTiming()
        self._seen = 0
        self._time = self._posed = 0.0
        self._came = self._clock()
        self._status = NO_GOAL
        self._told_nodes = -math.inf

    @property
    def refused(self) -> int:
        return self._always.refused + self._watched.refused

    @property
    def newest_refusal(self) -> str:
        """Text of the newest message that could not be read; "" before the first."""
        return self._watched.newest_refusal or self._always.newest_refusal

    @property
    def heard(self) -> list[str]:
        """Full names of the nodes that are not silent."""
        now = self._clock()
        return [name for name, report in self.reports.items() if now - report.came <= scene.SILENT_AFTER]

    def open(self) -> None:
        """Subscribes to everything that is shown."""
        listen = self._watched.listen
        self._reset()
        listen(Odometry, "mocap/odom", self._take_pose, POSES, raw=True)
        listen(LaserScan, "scan", self._take_scan, NEWEST)
        listen(MultiDOFJointTrajectory, "planner/trajectory", self._take_trajectory, qos.EVENT, raw=True)
        listen(Path, "plan", self._take_path, NEWEST, raw=True)
        listen(PointCloud2, "planner/seen", self._take_seen, qos.LATCHED)
        listen(PointCloud2, "planner/compared", self._take_compared, qos.LATCHED)
        listen(DiagnosticArray, "planner/costs", lambda message, _: self._put(costs_parts(message)), NEWEST)
        listen(GoalStatus, "goal_status", self._take_status, qos.LATCHED)
        listen(PoseStamped, "impact/contact", self._take_impact, qos.EVENT)
        listen(DiagnosticStatus, "controller/state", lambda message, _: self._put(doing_parts(message)), qos.LATCHED)
        listen(DiagnosticStatus, "robot/state", self._take_hold, qos.LATCHED)
        listen(command_type(self._settings.controller), "cmd_vel", self._take_command, COMMANDS)
        listen(DiagnosticArray, "/diagnostics", self._take_health, qos.DIAGNOSTICS_SUBSCRIBED)
        listen(DiagnosticStatus, "shared_constants", self._take_constants, qos.CONSTANTS_SUBSCRIBED)
        self._put_goal()

    def close(self) -> None:
        """Ends what `open` began."""
        self._watched.close()
        self.reports.clear()
        self.robot = ""

    def put(self) -> float:
        """Puts the parts gathered for a frame into the changes; returns the time of the frame [s]."""
        now = self._clock()
        self._put_robot(now)
        if self._periods:
            self._changes.put("periods", [round(1e3 * period, 1) for period in self._periods])
            self._periods = []
        if now - self._told_nodes >= NODES_PERIOD:
            self._told_nodes = now
            self._changes.put("nodes", scene.nodes(self.reports.values(), now))
        return scene.time_of(self._time)

    # ---- poses

    def _take_pose(self, raw: bytes, _: Values) -> None:
        state = state_from_bytes(raw, self._frames.map, self._frames.base)
        self._robot = scene.robot(state)
        if self._states and state.stamp < self._states[-1].stamp - STEP_BACK:
            self._begin_anew()
        self._states.append(state)
        self._fresh.append(state)
        while self._states[0].stamp < state.stamp - KEPT:
            self._states.popleft()

    def _begin_anew(self) -> None:
        """Drops parts of an earlier time, as after a restart of the robot."""
        self._states.clear()
        self._fresh.clear()
        self._impacts = ShownImpacts()
        self._put_impacts()

    def _put_robot(self, now: float) -> None:
        before = self._time
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
            self._time = self._posed + now - self._came
        if 0.0 < before - self._time < STEP_BACK:
            self._time = before

    # ---- scans

    def _take_scan(self, message: LaserScan, _: Values) -> None:
        mount = self._settings.scan
        scan = scan_from_message(message, self._frames.base, mount)
        if not self._states:
            return
        state = state_at(self._states, scan.stamp)
        self._changes.put("scan", scene.scan(placed_among(scan, state, self._states, mount), state))

    # ---- plans

    def _take_trajectory(self, raw: bytes, _: Values) -> None:
        plan = plan_from_trajectory(raw, self._frames.map)
        self._told = plan.stamp
        self._impacts.planned(plan)
        self._put_plan(plan)

    def _take_path(self, raw: bytes, _: Values) -> None:
        plan = plan_from_path(raw, self._frames.map)
        if plan.stamp != self._told:
            self._put_plan(plan)

    def _put_plan(self, plan: Plan) -> None:
        self._changes.put("plan", scene.plan(plan.stamp, plan.times, plan.positions, plan.contacts))

    def _take_seen(self, message: PointCloud2, _: Values) -> None:
        shown = LAYERS if self._seen % MEMORY_EVERY == 0 else LAYERS[: LAYERS.index(REMEMBERED)]
        self._put(seen_parts(message, self._frames.map, shown))
        self._seen += 1

    def _take_compared(self, message: PointCloud2, _: Values) -> None:
        self._put(compared_parts(message, self._frames.map))

    def _put(self, parts: Parts) -> None:
        for name, value in parts:
            self._changes.put(name, value)

    # ---- the goal

    def _take_goal(self, message: PoseStamped, _: Values) -> None:
        self.goal = goal_from_message(message, self._frames.map)
        self._put_goal()

    def _take_status(self, message: GoalStatus, _: Values) -> None:
        goal = goal_from_status(message)
        self._status = goal.status
        self._put_goal()
        if not goal.active:
            self._put(parts_without_goal())

    def _put_goal(self) -> None:
        self._changes.put("goal", scene.goal(self.goal, self._status))

    # ---- events and reports

    def _take_impact(self, message: PoseStamped, _: Values) -> None:
        self._impacts.happened(impact_contact_from_message(message, self._frames.map), self._states)
        self._put_impacts()

    def _put_impacts(self) -> None:
        self._changes.put("impacts", self._impacts.part)
        self._changes.put("counts", self._impacts.counts)

    def _take_hold(self, message: DiagnosticStatus, _: Values) -> None:
        self.robot = str(message.name)
        self._put(hold_parts(message))

    def _take_command(self, message: Twist | TwistStamped, info: Values) -> None:
        sent = 1e-9 * info["source_timestamp"]
        if 0.0 < sent - self._commanded < LONGEST_PERIOD:
            self._periods.append(sent - self._commanded)
            self.recent.commanded(sent - self._commanded, self._clock())
        self._commanded = sent

    def _take_health(self, message: DiagnosticArray, _: Values) -> None:
        for status in message.status:
            report = report_of(status, self._clock())
            if is_in(self._namespace, report.name) and self._is_known_or_fits(report.name):
                self.reports[report.name] = report
                if (factor := real_time_factor(report.values)) is not None:
                    self.recent.reported(factor, report.came)

    def _is_known_or_fits(self, name: str) -> bool:
        return name in self.reports or len(self.reports) < MOST_NODES

    def _take_constants(self, message: DiagnosticStatus, _: Values) -> None:
        if is_in(self._namespace, str(message.name)):
            self._parameters.take(message)
