"""Parameter files in ROS 2's own format, read and written without ROS.

/**:                      # or a node's name, with or without its namespace
  ros__parameters:
    planner:
      strategy: harness   # or planner.strategy: harness
"""

import logging
import re
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from collplan_core.parameters import GROUPS, Settings, all_specs, unknown_key
from collplan_core.parameters.groups import LOCKSTEP, is_without_effect, without_effect
from collplan_core.parameters.spec import ParameterError
from collplan_core.yaml_text import YamlError, dump_yaml, parse_yaml, read_text

SIM_TIME = "use_sim_time"
ROS_KEYS = (SIM_TIME, "start_type_description_service")
"""Keys that every ROS node declares itself."""

NODES = (
    "mocap_node",
    "lidar_node",
    "planner_node",
    "controller_node",
    "simulator_node",
    "base_node",
    "driver_node",
    "view_node",
    "firmware_emulator",
)
"""Names of the nodes that have parameters."""
GONE_NODES = ("teleop_node",)
"""Removed nodes: a file may still have a section for them."""

_PARAMETERS = "ros__parameters"
_EVERY_NODE = "/**"
_WILDCARDS = {"*": r"/\w+", "**": r"(/\w+)*"}
"""Names that stand for any one, and for any number of names, as a form of them."""
_FORM = f"NODE: {_PARAMETERS}: KEY: VALUE"


def read_parameters(path: str | Path, namespace: str = "/") -> dict[str, Any]:
    """Every `group.field` key of a file and its checked value, for all nodes of a namespace.

    A node's own section goes before those with a wildcard. Sections of other namespaces are left out, by the rule of
    ROS, and so are keys of ROS itself. A sentence is logged where the file holds removed parameters.

    Raises:
        ParameterError: no such file, not this format, a section for an unknown node or for no node of the namespace, a
            key that is unknown or given twice, a value that does not fit its parameter, or two nodes' sections that
            differ; names the file, the key, the value and what was expected.
    """
    try:
        values, words = _read(read_text(Path(path)), str(path), namespace)
    except YamlError as error:
        raise ParameterError(f"{path}: {error}") from None
    if words:
        logging.getLogger(__name__).warning("%s: %s", path, words)
    return values


def follows_clock(path: str | Path, namespace: str = "/") -> bool:
    """Returns whether use_sim_time is true for the nodes of a namespace, in a file that `read_parameters` takes.

    Raises:
        ParameterError: it is neither true nor false, or not the same for each node; names the file.
    """
    given: dict[str, Any] = {}
    space = f"/{namespace.strip('/')}".rstrip("/")
    for node, values in _of_namespace(list(_sections("", parse_yaml(read_text(Path(path)), as_ros=True))), space):
        if SIM_TIME in values:
            given[node.rsplit("/", 1)[-1]] = values[SIM_TIME]
    whole = [value for node, value in given.items() if node in _WILDCARDS][-1:]
    special = [value for node, value in given.items() if node not in _WILDCARDS]
    if not all(isinstance(value, bool) for value in given.values()):
        raise ParameterError(f"{path}: {SIM_TIME}: got {given}, expected true or false")
    if len({*whole, *special}) > 1:
        raise ParameterError(f"{path}: {SIM_TIME}: got {given}, expected one value for every node, under {_EVERY_NODE}")
    return any(given.values())


def parameters_of(text: str, source: str, namespace: str = "/") -> dict[str, Any]:
    """Returns the same of a file's text, without a sentence; `source` stands in the errors."""
    return _read(text, source, namespace)[0]


def _read(text: str, source: str, namespace: str) -> tuple[dict[str, Any], str]:
    """The values, and a sentence on what has no effect."""
    try:
        sections = list(_sections("", parse_yaml(text, as_ros=True)))
        values = _merged(_of_namespace(sections, f"/{namespace.strip('/')}".rstrip("/")))
        Settings().with_values(values)
    except (ParameterError, YamlError) as error:
        raise ParameterError(f"{source}: {error}") from None
    return values, without_effect(key for _, parameters in sections for key in parameters)


def write_parameters(settings: Settings, path: str | Path) -> None:
    """Writes every parameter and its value, for every node."""
    write_values(settings.values(), path)


def write_values(values: Mapping[str, Any], path: str | Path, comment: str = "") -> None:
    """Writes `group.field` keys and their values for every node, below a comment."""
    groups: dict[str, dict[str, Any]] = {}
    for key, value in values.items():
        group, name = key.split(".")
        groups.setdefault(group, {})[name] = value
    heading = "".join(f"# {line}\n" for line in comment.splitlines())
    Path(path).write_text(heading + dump_yaml({_EVERY_NODE: {_PARAMETERS: groups}}), encoding="utf-8")


def is_ros_key(key: str) -> bool:
    """Returns whether ROS itself declares a parameter of this name in every node."""
    return key in ROS_KEYS


def _sections(node: str, content: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """Node name and flat parameters of each section; namespaces may be nested."""
    if not isinstance(content, Mapping) or not content:
        raise ParameterError(f"{node or 'file'}: got {content!r:.80}, expected {_FORM}")
    for name, inner in content.items():
        if name == _PARAMETERS and node:
            yield node, _flat(inner)
        else:
            yield from _sections(f"{node}/{name}" if node else str(name), inner)


def _flat(content: Any) -> dict[str, Any]:
    """Parameters by their whole names."""
    if not isinstance(content, Mapping):
        raise ParameterError(f"{_PARAMETERS}: got {content!r:.80}, expected KEY: VALUE")
    found: dict[str, Any] = {}
    for key, value in _entries("", content):
        if key in found:
            raise ParameterError(f"{key}: given as {found[key]!r:.80} and as {value!r:.80}, expected it once")
        found[key] = value
    return found


def _entries(prefix: str, content: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _entries(f"{prefix}{name}.", value)
        elif value is None and f"{prefix}{name}" in {group.group for group in GROUPS}:
            raise ParameterError(f"{prefix}{name}: holds nothing, expected KEY: VALUE below it, or no such line")
        else:
            yield f"{prefix}{name}", value


def _of_namespace(sections: list[tuple[str, dict[str, Any]]], namespace: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """The sections that are for a node of a namespace, such as "/robot1" or ""."""
    used, of_the_root = 0, ""
    for node, parameters in sections:
        *spaces, name = node.strip("/").split("/")
        if name in GONE_NODES:
            used += 1
            continue
        pattern = "".join(_WILDCARDS.get(token, f"/{re.escape(token)}") for token in (*spaces, name))
        known = name in NODES or name in _WILDCARDS
        if any(re.fullmatch(pattern, f"{namespace}/{one}") for one in (NODES if known else (name,))):
            used += 1
            _check_node(node)
            yield node, parameters
        elif not spaces:
            _check_node(node)
            of_the_root = of_the_root or name
    if not used and of_the_root:
        got = f"/{of_the_root}: no node of {namespace} has this name"
        raise ParameterError(f"{got}, expected {namespace}/{of_the_root}")
    if not used:
        ours = f"{namespace}/** or {_EVERY_NODE}" if namespace else _EVERY_NODE
        raise ParameterError(f"no section is for nodes of {namespace or '/'}, expected {ours}")


def _merged(sections: Iterator[tuple[str, dict[str, Any]]]) -> dict[str, Any]:
    general: dict[str, Any] = {}
    special: dict[str, Any] = {}
    for node, parameters in sections:
        for key, value in _checked(parameters).items():
            if node.rsplit("/", 1)[-1] in _WILDCARDS:
                general[key] = value  # of several the last one goes, as for ROS
            elif special.setdefault(key, value) != value:
                raise ParameterError(f"{key}: got {special[key]!r} and, for {node}, {value!r}, expected one value")
    return general | special


def _check_node(node: str) -> None:
    """Raises ParameterError for a section of an unknown node, which ROS itself would ignore silently."""
    name = node.rsplit("/", 1)[-1]
    if name in NODES or name in _WILDCARDS:
        return
    near = get_close_matches(name, NODES, n=2, cutoff=0.8)
    hint = f"did you mean {' or '.join(near)}?" if near else f"expected {_EVERY_NODE} or one of {', '.join(NODES)}"
    raise ParameterError(f"{node}: unknown node, {hint}")


def _checked(parameters: dict[str, Any]) -> dict[str, Any]:
    known = all_specs()
    ours = {key: value for key, value in parameters.items() if not (is_ros_key(key) or is_without_effect(key))}
    if ours.pop(LOCKSTEP, False) is True:
        ours["simulator.speed_factor"] = 0.0
    for key in ours:
        if key not in known:
            raise unknown_key(key)
    return {key: known[key].checked(value) for key, value in ours.items()}
