"""Names of the nodes that publish a topic, as ROS lists them."""

from rclpy.node import Node

from collplan_ros.node_kit.node_names import full_name

UNKNOWN = "_NODE_NAME_UNKNOWN_"
"""Name under which ROS lists a node until it is discovered whole."""


def listed_publishers(node: Node, topic: str) -> list[str]:
    """Full name of the node of each publisher of `topic`, as given to rclpy; UNKNOWN for one not discovered whole."""
    found = node.get_publishers_info_by_topic(node.resolve_topic_name(topic))
    return [UNKNOWN if each.node_name == UNKNOWN else full_name(each.node_namespace, each.node_name) for each in found]


def known_publishers(node: Node, topic: str) -> list[str]:
    """Full name of the node of each publisher of `topic`, without those whose discovery is not complete."""
    return [name for name in listed_publishers(node, topic) if name != UNKNOWN]
