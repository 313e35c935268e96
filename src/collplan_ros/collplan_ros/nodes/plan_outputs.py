"""What planner_node tells of a plan."""

import math
from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Path
from rclpy.node import Node
from visualization_msgs.msg import MarkerArray

from collplan_core.evaluation.rebound_tracking import MeasuredImpact
from collplan_core.local_map import LocalMap
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_ros.markers.plan_markers import plan_markers
from collplan_ros.messages import qos
from collplan_ros.messages.conversions import contacts_to_path, plan_to_path
from collplan_ros.nodes.cost_report import costs_message

MARKERS_PERIOD = 0.2
"""Markers take as long to make as a plan: they are not made more often [s]."""


@dataclass(frozen=True, eq=False)
class Cycle:
    """What one cycle of the planner led to.

    Attributes:
        plan: the choice.
        local_map: it was made in.
        memory: what the objective keeps.
        planning_time: [s].
        hit: measured since the last cycle, if there was one.
    """

    plan: Plan
    local_map: LocalMap
    memory: Any
    planning_time: float
    hit: MeasuredImpact | None


class PlanOutputs:
    """Publishes plan, planner/foreseen_impacts and planner/costs of each cycle, and planner/markers for who looks."""

    def __init__(self, node: Node) -> None:
        """Publishes by `node`."""
        self._name = node.get_fully_qualified_name()
        self._plan = node.create_publisher(Path, "plan", qos.NEWEST)
        self._contacts = node.create_publisher(Path, "planner/foreseen_impacts", qos.EVENT)
        self._costs = node.create_publisher(DiagnosticArray, "planner/costs", qos.EVENT)
        self._markers = node.create_publisher(MarkerArray, "planner/markers", qos.LATCHED)
        self._marked = -math.inf
        self._hit: MeasuredImpact | None = None

    def publish(self, cycle: Cycle, local: float, settings: Settings) -> None:
        """The plan first: the robot waits for it. `local` [s, local clock]."""
        plan, frame = cycle.plan, settings.frames.map
        self._plan.publish(plan_to_path(plan, frame))
        self._contacts.publish(contacts_to_path(plan.contacts, plan.stamp, frame))
        strategy = settings.planner.strategy
        self._costs.publish(costs_message(self._name, plan, cycle.planning_time, strategy, cycle.hit))
        self._hit = cycle.hit or self._hit
        if self._markers.get_subscription_count() and not 0.0 <= local - self._marked < MARKERS_PERIOD:
            self._marked = local
            self._markers.publish(plan_markers(cycle.local_map, plan, cycle.memory, self._hit, settings))
