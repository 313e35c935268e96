"""What planner_node publishes about each plan."""

import math
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Path
from rclpy.node import Node
from sensor_msgs.msg import TimeReference
from trajectory_msgs.msg import MultiDOFJointTrajectory
from visualization_msgs.msg import MarkerArray

from collplan_core.evaluation.rebound_tracking import MeasuredImpact
from collplan_core.local_map import LocalMap
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.time_to_goal_planner.boundary_memory.record import RememberedBoundaries
from collplan_ros.markers.plan_markers import plan_markers
from collplan_ros.messages import qos
from collplan_ros.messages.plans import contacts_to_message, plan_to_path, validity_to_message
from collplan_ros.nodes.cost_report import costs_message

MARKERS_PERIOD = 0.2
"""Shortest time between two sets of markers, which take as long to make as a plan [s]."""


@dataclass(frozen=True, eq=False)
class Cycle:
    """Result of one planning cycle.

    Attributes:
        plan: the plan chosen.
        valid_until: until when the plan may be followed [s, poses' clock].
        local_map: local map that it was made in.
        boundaries: what the planner remembers of boundaries; None where it remembers none.
        planning_time: duration of the cycle [s].
        impact: impact measured since the previous cycle; None where there was none.
    """

    plan: Plan
    valid_until: float
    local_map: LocalMap
    boundaries: RememberedBoundaries | None
    planning_time: float
    impact: MeasuredImpact | None


class PlanOutputs:
    """Publishes of each cycle plan, what goes with it, and planner/costs, and planner/markers if subscribed."""

    def __init__(self, node: Node) -> None:
        """Publishes through `node`."""
        self._name = node.get_fully_qualified_name()
        self._plan = node.create_publisher(Path, "plan", qos.NEWEST)
        self._valid_until = node.create_publisher(TimeReference, "planner/valid_until", qos.EVENT)
        self._contacts = node.create_publisher(MultiDOFJointTrajectory, "planner/foreseen_impacts", qos.EVENT)
        self._costs = node.create_publisher(DiagnosticArray, "planner/costs", qos.EVENT)
        self._markers = node.create_publisher(MarkerArray, "planner/markers", qos.LATCHED)
        self._markers_sent = -math.inf
        self._impact: MeasuredImpact | None = None

    def publish(self, cycle: Cycle, local: float, settings: Settings) -> None:
        """Publishes a cycle that ended at `local` [s, local clock].

        What goes with the plan is sent before it, to be known when it comes, and all else after it: the robot waits.
        """
        plan, frames = cycle.plan, settings.frames
        self._valid_until.publish(validity_to_message(plan.stamp, cycle.valid_until, self._name))
        self._contacts.publish(contacts_to_message(plan.contacts, plan.stamp, frames.map, frames.base))
        self._plan.publish(plan_to_path(plan, frames.map))
        strategy = settings.planner.strategy
        self._costs.publish(costs_message(self._name, plan, cycle.planning_time, strategy, cycle.impact))
        self._impact = cycle.impact or self._impact
        if self._markers.get_subscription_count() and not 0.0 <= local - self._markers_sent < MARKERS_PERIOD:
            self._markers_sent = local
            self._markers.publish(plan_markers(cycle.local_map, plan, cycle.boundaries, self._impact, settings))
