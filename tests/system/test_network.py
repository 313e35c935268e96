"""What a graph lets in, and whom it can hold up."""

import os
import subprocess
import sys
from functools import cache

import pytest

from collplan_ros.node_kit.reachability import PROFILE, RANGE, graph_environment

SOCKETS = """
import os, re, time
import rclpy
rclpy.init()
node = rclpy.create_node("alone")
files = [f"/proc/self/fd/{number}" for number in os.listdir("/proc/self/fd")]
links = [os.readlink(file) for file in files if os.path.islink(file)]
mine = {found[1] for link in links if (found := re.fullmatch(r"socket:\\[(\\d+)\\]", link))}
for table in ("udp", "udp6", "tcp", "tcp6"):
    for line in open(f"/proc/self/net/{table}").readlines()[1:]:
        if line.split()[9] in mine:
            address = line.split()[1].split(":")[0]
            print(".".join(str(part) for part in reversed(bytes.fromhex(address))))
print(sum("/dev/shm/fastrtps" in line for line in open("/proc/self/maps")), "shared")
"""
LOOPBACK, MULTICAST = "127.0.0.1", "239.255.0.1"


def environment(network):
    own = {key: value for key, value in os.environ.items() if key not in (RANGE, PROFILE)}
    return {**own, **graph_environment(network, own)}


@cache
def said(network):
    """The addresses that a node's sockets are bound to, and how much memory it shares."""
    done = subprocess.run([sys.executable, "-c", SOCKETS], env=environment(network), capture_output=True, text=True)
    *addresses, shared = done.stdout.splitlines()
    return set(addresses), shared, done.stderr


def test_a_local_graph_has_no_door_but_on_this_machine():
    addresses, _, errors = said("local")
    assert LOOPBACK in addresses <= {LOOPBACK, MULTICAST}, errors


@pytest.mark.parametrize("network", ["local", "subnet"])
def test_no_graph_shares_memory_with_a_process_that_may_freeze(network):
    _, shared, errors = said(network)
    assert shared.split() == ["0", "shared"], errors


def test_where_the_profile_is_not_ours_the_range_says_how_far_the_graph_reaches():
    assert graph_environment("subnet", graph_environment("local", {})) == graph_environment("subnet", {})
    for network, kept in (("local", "LOCALHOST"), ("subnet", "SUBNET")):
        for own in ({PROFILE: "/my/profile.xml"}, {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}):
            assert graph_environment(network, own) == {RANGE: kept}
