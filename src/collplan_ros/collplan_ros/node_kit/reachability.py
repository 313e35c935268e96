"""The environment variables by which nodes start and meet: set for a graph of an extent, and checked."""

import os
import socket
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from importlib.resources import files
from pathlib import Path

RANGES = {"local": "LOCALHOST", "subnet": "SUBNET"}
RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
PROFILE = "FASTRTPS_DEFAULT_PROFILES_FILE"
OWN_PROFILES = {network: str(files("collplan_ros") / "config" / f"fastdds_{network}.xml") for network in RANGES}
SERVER = "ROS_DISCOVERY_SERVER"
LAST_DOMAIN = 232
"""The largest domain whose ports exist."""
SERVER_PORT, ANSWER_TIME = 11811, 0.2
"""Port of a discovery server where none is given, and time in which a machine refuses another [s]."""


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


def why_no_graph(environment: Mapping[str, str], local: bool) -> str:
    """Why no node can reach another with these environment variables; "" where they can.

    Nodes that are `local` reach each other through the loopback interface alone.
    """
    domain = environment.get("ROS_DOMAIN_ID", "")
    if domain and not (domain.isdecimal() and int(domain) <= LAST_DOMAIN):
        return f"ROS_DOMAIN_ID: got {domain!r}, expected a whole number in [0, {LAST_DOMAIN}]"
    if environment.get("ROS_SECURITY_ENABLE") == "true" and environment.get("ROS_SECURITY_STRATEGY") == "Enforce":
        keys = environment.get("ROS_SECURITY_KEYSTORE", "")
        if not Path(keys, "enclaves").is_dir():
            return f"ROS_SECURITY_KEYSTORE: got {keys!r}, expected a keystore, or ROS_SECURITY_ENABLE=false"
    for server in filter(None, environment.get(SERVER, "").split(";")):
        if _is_refused(server):
            return f"{SERVER}: no server listens at {server}: start it, or unset {SERVER}"
    if not local:
        if environment.get("ROS_LOCALHOST_ONLY") == "1":
            return "ROS_LOCALHOST_ONLY: got '1', which keeps nodes of other machines away: unset it, or --network local"
        return ""
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as probe:
        try:
            probe.connect(("127.0.0.1", 9))  # sends nothing
        except OSError as error:
            return f"the loopback interface is down ({error.strerror}): ip link set lo up"
    return ""


def _is_refused(server: str) -> bool:
    """Returns whether the machine of `host`, or `host:port`, says that no discovery server listens there."""
    host, _, port = server.partition(":")
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as probe:
        probe.settimeout(ANSWER_TIME)
        try:
            probe.connect((host, int(port or SERVER_PORT)))
            probe.send(b"")
            probe.recv(1)
        except ConnectionRefusedError:
            return True
        except (OSError, ValueError):  # no answer, or a form that only the middleware reads
            pass
    return False


def why_no_logs(environment: Mapping[str, str]) -> str:
    """Returns why ROS has no folder for its logs; "" where it has one."""
    named = any(environment.get(key) for key in ("ROS_LOG_DIR", "ROS_HOME", "HOME"))
    return "" if named else "ROS_LOG_DIR: not set, and no HOME either, expected a folder for ROS's logs"
