"""Who commands the robot: a run goes on only while it is one node."""

from rclpy.node import Node

from collplan_ros.node_kit.shared_constants import UNKNOWN

TOPIC = "cmd_vel"


def other_commanders(node: Node, commander: str) -> list[str]:
    """Full names of the nodes other than `commander`, in the namespace of `node`, that publish commands.

    One of the commander's own name is not told apart here; bringup refuses a second node of that name at its start.
    """
    expected = f"{node.get_namespace().rstrip('/')}/{commander}"
    publishers = node.get_publishers_info_by_topic(node.resolve_topic_name(TOPIC))
    names = {
        f"{each.node_namespace.rstrip('/')}/{each.node_name}"
        for each in publishers
        if each.node_name != UNKNOWN  # listed with its name soon
    }
    return sorted(names - {expected})
