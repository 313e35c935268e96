"""What a recording says of a topic, as rosbag2 writes it: definitions of its types, and QoS of its publishers."""

import os
import re
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import yaml

NANO = 10**9


def offered_qos(publishers: Iterable[Any]) -> str:
    """YAML with a profile a publisher.

    `publishers` are rclpy's infos of them. The DDS in use tells neither history nor depth of a publisher of another
    process: these are then `unknown` and 0, as in what rosbag2 records.
    """
    profiles = [_profile(publisher.qos_profile) for publisher in publishers]
    return yaml.safe_dump(profiles, sort_keys=False) if profiles else ""


def _profile(qos: Any) -> dict[str, Any]:
    return {
        "history": qos.history.name.lower(),
        "depth": qos.depth,
        "reliability": qos.reliability.name.lower(),
        "durability": qos.durability.name.lower(),
        "deadline": _duration(qos.deadline),
        "lifespan": _duration(qos.lifespan),
        "liveliness": qos.liveliness.name.lower(),
        "liveliness_lease_duration": _duration(qos.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": qos.avoid_ros_namespace_conventions,
    }


def _duration(duration: Any) -> dict[str, int]:
    seconds, nanoseconds = divmod(duration.nanoseconds, NANO)
    return {"sec": seconds, "nsec": nanoseconds}


PRIMITIVE = {"bool", "byte", "char", "string", "wstring", "float32", "float64"} | {
    f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)
}
FIELD = re.compile(r"(?:^|\n)\s*([a-zA-Z0-9_/]+)(?:\[[^\]]*\])?\s+")
"""The type at the beginning of a line of a definition."""
RULE = "=" * 80


def type_name(kind: type) -> str:
    """Name of a message class, such as nav_msgs/msg/Odometry."""
    return f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}"


@cache
def schema_text(name: str) -> str | None:
    """Definition of a type such as nav_msgs/msg/Odometry and of every type in it, joined as rosbag2 does.

    None where one of them is not on this machine.
    """
    package, _, message = name.split("/")
    try:
        return _joined(f"{package}/{message}", set())
    except FileNotFoundError:
        return None


def _joined(name: str, seen: set[str]) -> str:
    """The definition of PACKAGE/MESSAGE and those of its types that were not `seen` before, which it adds to."""
    text = _definition(name)
    joined = text
    for part in sorted(_types_in(text, name.split("/")[0])):
        if part not in seen:
            seen.add(part)
            joined += f"\n{RULE}\nMSG: {part}\n{_joined(part, seen)}"
    return joined


def _types_in(text: str, package: str) -> set[str]:
    found = {match[1] for match in FIELD.finditer(text)} - PRIMITIVE
    return {kind if "/" in kind else f"{package}/{kind}" for kind in found}


def _definition(name: str) -> str:
    package, message = name.split("/")
    # without a sourced ROS nothing names the environment that Python runs in
    for prefix in (*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix):
        path = Path(prefix, "share", package, "msg", f"{message}.msg")
        if prefix and path.is_file():
            return path.read_text(encoding="utf-8")
    raise FileNotFoundError(name)
