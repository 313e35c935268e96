"""A bench for planner_node: the node alone, with a fake robot that stands in a hall."""

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path

from collplan_ros.messages.conversions import goal_to_message, seconds_from_stamp
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT
from collplan_ros.nodes.planner_node import PlannerNode
from fake_robot import FakeRobot, hall
from node_health import NodeHealth

AHEAD = np.array([2.0, 0.0])


def identity(status):
    return bytes(status.goal_info.goal_id.uuid)


class PlannerBench:
    """The node, a robot for it to plan for, and what it says."""

    def __init__(self, ros, world=None, **parameters):
        self.ros = ros
        self.plans = ros.listen(Path, "plan", EVENT)
        self.costs = ros.listen(DiagnosticArray, "planner/costs", EVENT)
        self.statuses = ros.listen(GoalStatus, "goal_status", DIAGNOSTICS_SUBSCRIBED)
        self.health = NodeHealth(ros, "/planner_node")
        self.robot = FakeRobot(ros, world or hall())
        overrides = {"planner.map_period": 0.05, **{k.replace("__", "."): v for k, v in parameters.items()}}
        self.node = ros.make(PlannerNode, overrides)
        self.goals = ros.publisher(PoseStamped, "goal_pose", EVENT)
        assert ros.wait_until(self.robot.is_heard)
        assert ros.wait_until(lambda: self.statuses)

    def send_goal(self, goal=AHEAD, frame="map"):
        """A goal, taken by the node before this returns; its first status."""
        known = {identity(status) for status in self.statuses}
        self.goals.publish(goal_to_message(goal, frame))
        assert self.ros.wait_until(lambda: [s for s in self.statuses if identity(s) not in known])
        return next(s for s in self.statuses if identity(s) not in known)

    def wait_for(self, status):
        assert self.ros.wait_until(lambda: self.statuses and self.statuses[-1].status == status)
        return self.statuses[-1]

    def wait_for_plan(self, after=0.0):
        """The first plan from a pose later than `after`."""
        assert self.ros.wait_until(lambda: self._plans_after(after)), self.health.newest
        return self._plans_after(after)[0]

    def _plans_after(self, stamp):
        # a message's stamp is rounded to nanoseconds
        return [p for p in self.plans if seconds_from_stamp(p.header.stamp) > stamp + 1e-6]

    def assert_no_more_plans(self):
        """None goes out from now on."""
        self.ros.spin(0.05)
        before = len(self.plans)
        self.ros.spin(0.25)
        assert len(self.plans) == before
