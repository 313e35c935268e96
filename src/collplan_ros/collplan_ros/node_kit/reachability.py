"""Checks that nodes can start and meet on this machine."""

import socket
from collections.abc import Mapping
from contextlib import closing

LAST_DOMAIN = 232
"""The largest domain whose ports exist."""


def why_no_graph(environment: Mapping[str, str], local: bool) -> str:
    """Returns why no node can reach another with these environment variables; "" where they can.

    Nodes that are `local` reach each other through the loopback interface alone.
    """
    domain = environment.get("ROS_DOMAIN_ID", "")
    if domain and not (domain.isdecimal() and int(domain) <= LAST_DOMAIN):
        return f"ROS_DOMAIN_ID: got {domain!r}, expected a whole number in [0, {LAST_DOMAIN}]"
    if not local:
        return ""
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as probe:
        try:
            probe.connect(("127.0.0.1", 9))  # sends nothing
        except OSError as error:
            return f"the loopback interface is down ({error.strerror}): ip link set lo up"
    return ""


def why_no_logs(environment: Mapping[str, str]) -> str:
    """Returns why ROS has no folder for its logs; "" where it has one."""
    named = any(environment.get(key) for key in ("ROS_LOG_DIR", "ROS_HOME", "HOME"))
    return "" if named else "ROS_LOG_DIR: not set, and no HOME either, expected a folder for ROS's logs"
