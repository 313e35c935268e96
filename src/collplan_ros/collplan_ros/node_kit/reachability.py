"""Whether nodes on this machine can meet."""

import socket
from collections.abc import Mapping
from contextlib import closing

LAST_DOMAIN = 232
"""The largest domain whose ports exist."""


def why_no_graph(environment: Mapping[str, str]) -> str:
    """Returns why no node of this machine can reach another with these environment variables; "" where they can."""
    domain = environment.get("ROS_DOMAIN_ID", "")
    if domain and not (domain.isdecimal() and int(domain) <= LAST_DOMAIN):
        return f"ROS_DOMAIN_ID: got {domain!r}, expected a whole number in [0, {LAST_DOMAIN}]"
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as probe:
        try:
            probe.connect(("127.0.0.1", 9))  # sends nothing
        except OSError as error:
            return f"the loopback interface is down ({error.strerror}): ip link set lo up"
    return ""
