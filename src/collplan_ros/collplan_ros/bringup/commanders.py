"""Who commands the robot: a run goes on only while it is one node."""

from rclpy.node import Node

from collplan_ros.node_kit.node_names import full_name
from collplan_ros.node_kit.publishers import known_publishers

TOPIC = "cmd_vel"


def other_commanders(node: Node, commander: str) -> list[str]:
    """Full names of the nodes other than `commander`, in the namespace of `node`, that publish commands.

    One of the commander's own name is not told apart here; bringup refuses a second node of that name at its start.
    """
    return sorted(set(known_publishers(node, TOPIC)) - {full_name(node.get_namespace(), commander)})
