"""Impacts that a robot tells of in a message of its own: an adapter, and the planner that hears of them."""

import numpy as np
import pytest
from geometry_msgs.msg import Vector3Stamped

from collplan_core.state import State
from collplan_ros.messages.qos import EVENT
from collplan_ros.nodes.planner_node import PlannerNode
from fake_robot import FakeRobot, hall
from hit_adapter import REBOUND, HitAdapter
from node_health import NodeHealth

YAW, SPEED = 0.5, 0.8
AHEAD = np.array([np.cos(YAW), np.sin(YAW)])


class Driving(FakeRobot):
    """Says that it drives ahead."""

    @property
    def state(self) -> State:
        return State(self.stamp, self.position, SPEED * AHEAD, self.yaw)


def test_a_felt_collision_is_an_impact_for_the_planner(ros, real_messages):
    hits = real_messages("robomaster_msgs.msg").ArmorHit
    robot, health = Driving(ros, hall(), YAW), NodeHealth(ros, "/planner_node")
    impacts = ros.listen(Vector3Stamped, "impact", EVENT)
    ros.make(PlannerNode)
    adapter = ros.add(HitAdapter(hits, context=ros.context))
    armor = ros.publisher(hits, "hit")
    assert ros.wait_until(lambda: robot.is_heard() and adapter.count_subscribers("impact") == 2)
    # by infrared, from behind, and at the turret: none of them
    armor.publish(hits(type=hits.IR, location=hits.BOTTOM_FRONT))
    armor.publish(hits(type=hits.COLLISION, location=hits.BOTTOM_BACK))
    armor.publish(hits(type=hits.COLLISION, location=hits.TOP_LEFT))
    armor.publish(hits(type=hits.COLLISION, location=hits.BOTTOM_FRONT, level=40))
    assert ros.wait_until(lambda: impacts)
    (impact,) = impacts
    assert impact.header.frame_id == "map"
    change = -(1.0 + REBOUND) * SPEED * AHEAD
    assert (impact.vector.x, impact.vector.y) == pytest.approx(tuple(change))
    assert health.counts("impacts")
    assert (health.count("impacts"), health.count("refused_impact")) == (1, 0)
