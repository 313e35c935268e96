"""Extent of the graph: discovery range and Fast DDS profile, passed to the nodes in the environment."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.resources import files

RANGES = {"local": "LOCALHOST", "subnet": "SUBNET"}
PROFILE = "FASTRTPS_DEFAULT_PROFILES_FILE"


def graph_environment(network: str, environment: Mapping[str, str]) -> dict[str, str]:
    """Environment variables of a graph that is `local` or `subnet`; a Fast DDS profile set by the user is kept."""
    chosen = {"ROS_AUTOMATIC_DISCOVERY_RANGE": RANGES[network]}
    if not environment.get(PROFILE):
        chosen[PROFILE] = str(files("collplan_ros") / "config" / "fastdds_local.xml")
    return chosen


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


def described() -> str:
    """Domain and discovery range in words."""
    domain = os.environ.get("ROS_DOMAIN_ID") or "0"
    return f"domain {domain}, discovery range {os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE']}"
