"""Outputs of planner_node: messages and log lines for the decisions of its loop."""

import math
from collections.abc import Sequence

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Path
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

from collplan_core.goal import Goal
from collplan_core.loop.decisions import INFO, WARNING, Cycle, Decision, Notice
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.movers.record import NO_MOVERS, Movers
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_ros.markers.plan_markers import plan_markers
from collplan_ros.messages import qos
from collplan_ros.messages.conversions import stamp_from_seconds
from collplan_ros.messages.mover_markers import found_to_markers
from collplan_ros.messages.planner_clouds import compared_to_message, plan_to_message, seen_layers, seen_to_message
from collplan_ros.messages.raw_reading import plan_to_path
from collplan_ros.messages.states import goal_to_status, status_message
from collplan_ros.node_kit.diagnostics import ERROR, OK, WARN, Health
from collplan_ros.node_kit.run_node import publish_acknowledged


def costs_message(name: str, plan: Plan, planning_time: float, strategy: str) -> DiagnosticArray:
    """Message with each cost term of the chosen candidate, candidate counts before and after pruning, planning time.

    `name` is the full name of the publishing node; the stamp is the plan's; `planning_time` [s] is given in ms.
    """
    values: dict[str, object] = {
        "planning_time_ms": 1e3 * planning_time,
        "candidates": len(plan.candidates.costs),
        "candidates_before_pruning": plan.n_before_pruning,
        "foreseen_contacts": len(plan.contacts.times),
        "hardest_contact": plan.contacts.hardest,
        **plan.terms,
        "strategy": strategy,
    }
    message = DiagnosticArray(status=[status_message(name, OK, "costs of the choice", values)])
    message.header.stamp = stamp_from_seconds(plan.stamp)
    return message


MARKERS_PERIOD = 0.2
"""Shortest time between two sets of markers, which take as long to make as a plan [s]."""
CLOUDS_PERIOD = 0.1
"""Shortest time between two sets of point clouds [s]."""


class PlannerOutputs:
    """Publishes goal_status, movers and the topics of a plan; topics for display only where they are subscribed."""

    def __init__(self, node: Node) -> None:
        """Publishes through `node`."""
        self._name = node.get_fully_qualified_name()
        self._log = node.get_logger()
        self._status = node.create_publisher(GoalStatus, "goal_status", qos.LATCHED)
        # a planner that ran earlier may have left a goal active
        self._status.publish(GoalStatus(status=GoalStatus.STATUS_UNKNOWN))
        self._plan = node.create_publisher(Path, "plan", qos.NEWEST_PUBLISHED)
        self._trajectory = node.create_publisher(PointCloud2, "planner/trajectory", qos.EVENT)
        self._costs = node.create_publisher(DiagnosticArray, "planner/costs", qos.EVENT)
        self._markers = node.create_publisher(MarkerArray, "planner/markers", qos.LATCHED)
        self._markers_sent = -math.inf
        self._seen = node.create_publisher(PointCloud2, "planner/seen", qos.LATCHED)
        self._compared = node.create_publisher(PointCloud2, "planner/compared", qos.LATCHED)
        self._clouds_sent = -math.inf
        self._movers = node.create_publisher(MarkerArray, "movers", qos.EVENT)
        self._found = NO_MOVERS

    def take(
        self, decisions: Sequence[Decision], loop: PlannerLoop, planning_time: float, local: float, settings: Settings
    ) -> None:
        """Publishes and logs a loop's decisions at `local` [s, local clock]; a plan took `planning_time` [s]."""
        for decision in decisions:
            if isinstance(decision, Goal):
                self._status.publish(goal_to_status(decision))
            elif isinstance(decision, Cycle):
                self._publish(decision, loop.goal.position, planning_time, local, settings)
            else:
                self._say(decision)
        if loop.movers is not self._found:
            self._publish_movers(loop.movers, settings.frames.map)

    def take_last(self, decisions: Sequence[Decision]) -> None:
        """Publishes the goal's status, and waits until subscribers have received it."""
        for decision in decisions:
            if isinstance(decision, Goal):
                publish_acknowledged(self._status, goal_to_status(decision))

    def _say(self, notice: Notice) -> None:
        # a call for each: rclpy lets no place in the code change its level
        if notice.level == INFO:
            self._log.info(notice.text)
        elif notice.level == WARNING:
            self._log.warning(notice.text)
        else:
            self._log.error(notice.text)

    def _publish(self, cycle: Cycle, goal: np.ndarray, planning_time: float, local: float, settings: Settings) -> None:
        # the trajectory first, as its receivers need no path, and all else after the plan: the robot waits
        plan, frame = cycle.plan, settings.frames.map
        self._trajectory.publish(plan_to_message(plan, frame))
        self._plan.publish(plan_to_path(plan, frame))
        strategy = settings.planner.strategy
        self._costs.publish(costs_message(self._name, plan, planning_time, strategy))
        if self._markers.get_subscription_count() and not 0.0 <= local - self._markers_sent < MARKERS_PERIOD:
            self._markers_sent = local
            self._markers.publish(plan_markers(cycle.local_map, plan, cycle.boundaries, goal, settings))
        self._publish_clouds(cycle, local, settings)

    def _publish_movers(self, found: Movers, frame: str) -> None:
        """Publishes the movers of each scan, and once that there are none any more."""
        before, self._found = self._found, found
        if len(found) or len(before):
            self._movers.publish(found_to_markers(found, max(found.stamp, before.stamp), frame))

    def _publish_clouds(self, cycle: Cycle, local: float, settings: Settings) -> None:
        looks = self._seen.get_subscription_count() or self._compared.get_subscription_count()
        if not looks or 0.0 <= local - self._clouds_sent < CLOUDS_PERIOD:
            return
        self._clouds_sent = local
        stamp, frame = cycle.plan.stamp, settings.frames.map
        self._seen.publish(seen_to_message(seen_layers(cycle.local_map, cycle.boundaries, settings), stamp, frame))
        self._compared.publish(compared_to_message(cycle.plan.candidates, stamp, frame))


def health_of(loop: PlannerLoop, strategy: str, planning_time: float, local: float) -> Health:
    """The health of the node around a loop at `local` [s, local clock]; its newest plan took `planning_time` [s]."""
    active = loop.goal.active
    values: dict[str, object] = {
        "goal": loop.goal.status,
        "strategy": strategy,
        "plans": loop.n_plans,
        "planning_time_ms": 1e3 * planning_time,
        "impacts": loop.n_impacts,
        "plans_above_impact_speed": loop.n_hard_plans,
    }
    stale = ERROR if active else WARN, loop.why_stale(local)
    return Health.of(values, "planning" if active else "no active goal", stale, (WARN, loop.trouble))
