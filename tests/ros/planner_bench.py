"""A bench for planner_node: the node alone, with a fake robot that stands in a hall."""

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from sensor_msgs.msg import TimeReference
from trajectory_msgs.msg import MultiDOFJointTrajectory

from collplan_ros.messages.conversions import goal_to_message, seconds_from_stamp
from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED, EVENT
from collplan_ros.nodes.planner_node import PlannerNode
from fake_robot import FakeRobot, hall

AHEAD = np.array([2.0, 0.0])


def identity(status):
    return bytes(status.goal_info.goal_id.uuid)


class PlannerBench:
    """The node, a robot for it to plan for, and everything it says."""

    def __init__(self, ros, world=None, **parameters):
        self.ros = ros
        self.plans = ros.listen(Path, "plan", EVENT)
        self.contacts = ros.listen(MultiDOFJointTrajectory, "planner/foreseen_impacts", EVENT)
        self.valid_until = ros.listen(TimeReference, "planner/valid_until", EVENT)
        self.costs = ros.listen(DiagnosticArray, "planner/costs", EVENT)
        self.statuses = ros.listen(GoalStatus, "goal_status", DIAGNOSTICS_SUBSCRIBED)
        self.reports = ros.listen(DiagnosticArray, "/diagnostics", DIAGNOSTICS_SUBSCRIBED)
        self.robot = FakeRobot(ros, world or hall())
        overrides = {"planner.map_period": 0.05, **{k.replace("__", "."): v for k, v in parameters.items()}}
        self.node = ros.make(PlannerNode, overrides)
        self.goals = ros.publisher(PoseStamped, "goal_pose", EVENT)
        assert ros.wait_until(
            lambda: self.node._loop._sensors.state is not None and self.node._loop._sensors.scan_stamp is not None
        )
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
        """The first plan from a scan later than `after`."""
        assert self.ros.wait_until(lambda: self._plans_after(after))
        return self._plans_after(after)[0]

    def _plans_after(self, stamp):
        # a message's stamp is rounded to nanoseconds
        return [p for p in self.plans if seconds_from_stamp(p.header.stamp) > stamp + 1e-6]

    def health(self) -> DiagnosticStatus:
        """The newest health, asked for now."""
        before = len(self.reports)
        self.node._diagnostics.publish()
        assert self.ros.wait_until(lambda: len(self.reports) > before)
        return self.reports[-1].status[0]

    def wait_for_count(self, key, count=1):
        """The health once at least so many are counted."""
        assert self.ros.wait_until(lambda: int(self.value(key) or 0) >= count)
        return self.health()

    def value(self, key):
        return {v.key: v.value for v in self.health().values}.get(key, "")

    def assert_no_more_plans(self):
        """None goes out from now on."""
        self.ros.spin(0.05)
        before = len(self.plans)
        self.ros.spin(0.25)
        assert len(self.plans) == before
