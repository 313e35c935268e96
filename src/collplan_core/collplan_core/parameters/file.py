"""Parameter files in ROS 2's own format, read and written without ROS.

/**:                      # or a node's name, with or without its namespace
  ros__parameters:
    planner:
      strategy: harness   # or planner.strategy: harness
"""

import re
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from collplan_core.parameters import Settings, all_specs, unknown_key
from collplan_core.parameters.spec import ParameterError

ROS_KEYS = ("use_sim_time", "start_type_description_service")
"""Keys that every ROS node declares itself."""

NODES = (
    "mocap_node",
    "lidar_node",
    "planner_node",
    "controller_node",
    "simulator_node",
    "driver_node",
    "view_node",
    "teleop_node",
    "firmware_emulator",
)
"""Names of the nodes that have parameters."""

LONGEST = 1 << 20
"""Largest parameter file [bytes]; one with every parameter has a hundredth of it."""

_PARAMETERS = "ros__parameters"
_EVERY_NODE = "/**"
_WILDCARDS = ("*", "**")


class _Loader(yaml.SafeLoader):
    """Reads 1e-3 as a number and refuses aliases, as ROS does; YAML 1.1 does neither."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            event = self.peek_event()
            raise ParameterError(f"line {event.start_mark.line + 1}: got the alias *{event.anchor}, expected a value")
        return super().compose_node(parent, index)


class _Dumper(yaml.SafeDumper):
    """Quotes text that ROS would take for a number."""


for kind in (_Loader, _Dumper):
    kind.add_implicit_resolver(
        "tag:yaml.org,2002:float", re.compile(r"[-+]?[0-9]+[eE][-+]?[0-9]+$"), list("-+0123456789")
    )


def read_parameters(path: str | Path) -> dict[str, Any]:
    """Every `group.field` key of a file and its checked value, whichever node it is for.

    A node's own section goes before the one for every node (`/**`). Keys of ROS itself are left out.

    Raises:
        ParameterError: no such file, not this format, a section for an unknown node, an unknown key, a value that does
            not fit its parameter, or two nodes' sections that differ; names the file, the key, the value and what
            was expected.
    """
    try:
        values = _merged(_sections("", _loaded(path)))
        Settings().with_values(values)
    except ParameterError as error:
        raise ParameterError(f"{path}: {error}") from None
    return values


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
    Path(path).write_text(heading + yaml.dump({_EVERY_NODE: {_PARAMETERS: groups}}, Dumper=_Dumper, sort_keys=False))


def is_ros_key(key: str) -> bool:
    """Returns whether ROS itself declares a parameter of this name in every node."""
    return key in ROS_KEYS


def _loaded(path: str | Path) -> Any:
    try:
        with Path(path).open("rb") as file:
            text = file.read(LONGEST + 1)
        if len(text) > LONGEST:
            raise ParameterError(f"longer than {LONGEST} bytes, expected a parameter file")
        return yaml.load(text.decode(), _Loader)
    except RecursionError:
        raise ParameterError(f"nested too deep, expected NODE: {_PARAMETERS}: KEY: VALUE") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ParameterError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    except yaml.YAMLError as error:
        raise ParameterError(f"not YAML: {' '.join(str(error).split())}") from None


def _sections(node: str, content: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """Node name and flat parameters of each section; namespaces may be nested."""
    if not isinstance(content, Mapping) or not content:
        raise ParameterError(f"{node or 'file'}: got {content!r}, expected NODE: {_PARAMETERS}: KEY: VALUE")
    for name, inner in content.items():
        if name == _PARAMETERS and node:
            yield node, dict(_flat("", inner))
        else:
            yield from _sections(f"{node}/{name}" if node else str(name), inner)


def _flat(prefix: str, content: Any) -> Iterator[tuple[str, Any]]:
    if not isinstance(content, Mapping):
        raise ParameterError(f"{_PARAMETERS}: got {content!r}, expected KEY: VALUE")
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _flat(f"{prefix}{name}.", value)
        else:
            yield f"{prefix}{name}", value


def _merged(sections: Iterator[tuple[str, dict[str, Any]]]) -> dict[str, Any]:
    general: dict[str, Any] = {}
    special: dict[str, Any] = {}
    for node, parameters in sections:
        _check_node(node)
        for key, value in _checked(parameters).items():
            if node == _EVERY_NODE:
                general[key] = value
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
    ours = {key: value for key, value in parameters.items() if not is_ros_key(key)}
    for key in ours:
        if key not in known:
            raise unknown_key(key)
    return {key: known[key].checked(value) for key, value in ours.items()}
