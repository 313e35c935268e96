"""Who commands the robot: a run goes on only while it is one node."""

from rclpy.node import Node

TOPIC = "cmd_vel"


def other_commanders(node: Node, commander: str) -> list[str]:
    """Full names of the nodes other than `commander`, in the namespace of `node`, that publish commands.

    A second publisher of the commander's own name counts as another one.
    """
    expected = f"{node.get_namespace().rstrip('/')}/{commander}"
    publishers = node.get_publishers_info_by_topic(node.resolve_topic_name(TOPIC))
    names = [f"{each.node_namespace.rstrip('/')}/{each.node_name}" for each in publishers]
    if expected in names:
        names.remove(expected)
    return sorted(names)
