"""Definitions of message types, as a recording holds them for readers that have no ROS."""

import os
import re
import sys
from functools import cache
from pathlib import Path

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
