"""Nodes in the domain that are not of this graph, or command its robot too."""

from collections import Counter

from rclpy.node import Node

from collplan_ros.node_kit.node_names import full_name
from collplan_ros.node_kit.publishers import known_publishers

COMMANDS = "cmd_vel"
"""The topic of commands."""


def other_commanders(node: Node, commander: str) -> list[str]:
    """Full names of the nodes other than `commander`, in the namespace of `node`, that publish commands.

    A second node of the commander's own name is not detected here; bringup refuses it at its start.
    """
    return sorted(set(known_publishers(node, COMMANDS)) - {full_name(node.get_namespace(), commander)})


def seen_more_than(node: Node, expected: Counter[str]) -> list[str]:
    """Names of which more nodes are seen in the namespace of `node` than expected; names not listed do not count."""
    namespace = node.get_namespace()
    seen = Counter(name for name, space in node.get_node_names_and_namespaces() if space == namespace)
    return sorted(name for name, count in expected.items() if seen[name] > count)
