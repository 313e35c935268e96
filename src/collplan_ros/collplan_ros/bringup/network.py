"""Extent of the graph: discovery range and Fast DDS profile, passed to the nodes in the environment."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.resources import files

from collplan_ros.node_kit.reachability import SERVER

RANGES = {"local": "LOCALHOST", "subnet": "SUBNET"}
RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
PROFILE = "FASTRTPS_DEFAULT_PROFILES_FILE"
OWN_PROFILES = {network: str(files("collplan_ros") / "config" / f"fastdds_{network}.xml") for network in RANGES}


def graph_environment(network: str, environment: Mapping[str, str], alone: bool = False) -> dict[str, str]:
    """Environment variables of a graph that is `local` or `subnet`; one that is `alone` needs no discovery server.

    Fast DDS is given a profile that names its interfaces, and the discovery range leaves that to the profile:
    by itself it would add shared memory. A profile set by the user is kept; then, and with another middleware, the
    discovery range says it.
    """
    served = {SERVER: ""} if alone and environment.get(SERVER) else {}
    middleware = environment.get("RMW_IMPLEMENTATION") or "rmw_fastrtps_cpp"
    is_users = (environment.get(PROFILE) or OWN_PROFILES[network]) not in OWN_PROFILES.values()
    if is_users or not middleware.startswith("rmw_fastrtps"):
        return {RANGE: RANGES[network], **served}
    return {RANGE: "SYSTEM_DEFAULT", PROFILE: OWN_PROFILES[network], **served}


@contextmanager
def environment_set(values: Mapping[str, str]) -> Iterator[None]:
    """Sets environment variables of this process and its children, and restores the old values on leaving."""
    before = {key: os.environ.get(key) for key in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for key, value in before.items():
            if value is None:
                os.environ.pop(key, None)
            else:
                os.environ[key] = value
