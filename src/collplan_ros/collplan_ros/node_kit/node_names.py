"""Full names of nodes, and which robot's they are: each robot of a domain has a namespace of its own."""

import re

_NAMESPACE = re.compile(r"(/[A-Za-z_]\w*)+", re.ASCII)


def namespace_from(text: str) -> str:
    """The namespace that a user names, `robot1` or `/robot1`, with its leading slash; "/" for an empty text.

    ValueError: ROS accepts none like it; the text names what was given and what was expected.
    """
    namespace = "/" + text.removeprefix("/")
    if namespace != "/" and not _NAMESPACE.fullmatch(namespace):
        raise ValueError(
            f"namespace: got {text!r}, expected letters, digits and _, as robot1, in parts that begin with no digit"
        )
    return namespace


def full_name(namespace: str, node: str) -> str:
    """Full name of a node in a namespace."""
    return f"{namespace.rstrip('/')}/{node}"


def is_in(namespace: str, name: str) -> bool:
    """Returns whether a full name is that of a node in exactly this namespace, not in one within it."""
    return name.rpartition("/")[0] == namespace.rstrip("/")
