"""The one reader of YAML: parameter files, worlds and maps.

A value is a number, a truth value or text where ROS's own reader of parameter files takes it for one: `1e-3` is a
number, `1:30`, `1_000` and dates are text. A key given twice is an error.
"""

import re
from collections.abc import Hashable, Iterator
from pathlib import Path
from typing import Any

import yaml

LONGEST = 1 << 20
"""Largest file [bytes]; a world of 10,000 circles has half of it and takes 2 s to read."""
MOST_NODES = 1 << 20
"""Most values of a text whose aliases are written out."""
WIDTH = 120
"""Width at which lines are broken."""
_TAG = "tag:yaml.org,2002:"
_PLAIN = {
    "bool": r"[yY]|yes|Yes|YES|[nN]|no|No|NO|true|True|TRUE|false|False|FALSE|on|On|ON|off|Off|OFF",
    "int": r"[-+]?(?:0x[0-9a-fA-F]+|0[0-7]+|[1-9][0-9]*|0)",
    "float": r"[-+]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|\.?(?i:inf|nan|infinity))",
    "null": r"~|null|Null|NULL|",
    "merge": "<<",
}
"""Forms of plain text that are no text, by the kind of their value."""


class YamlError(ValueError):
    """A text that cannot be read; the message says in which line, and what was expected."""


def read_text(path: Path) -> str:
    """Returns the text of a file.

    Raises:
        YamlError: it cannot be read, is longer than LONGEST, or is not UTF-8.
    """
    try:
        with path.open("rb") as file:
            held = file.read(LONGEST + 1)
        if len(held) > LONGEST:
            size = max(path.stat().st_size, len(held))
            raise YamlError(f"got {size} bytes, expected at most {LONGEST}")
        return held.decode()
    except FileNotFoundError:
        raise YamlError("no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise YamlError(f"cannot be read as text: {getattr(error, 'strerror', None) or error}") from None


def parse_yaml(text: str, as_ros: bool = False) -> Any:
    """Returns the content of a text, one YAML document.

    Args:
        as_ros: a mapping that is given twice is merged, key by key, and an alias is an error, as for ROS.

    Raises:
        YamlError: not YAML, a key given twice in one mapping, nested too deep, or aliases that grow too far.
    """
    try:
        loader = _Loader(text)
        node = loader.get_single_node()
        if node is None:
            return None
        _count(node, as_ros, {})
        return loader.construct_document(_checked(node, as_ros))
    except YamlError:
        raise
    except RecursionError:
        raise YamlError("nested too deep, expected keys and values") from None
    except (yaml.YAMLError, ValueError) as error:
        raise YamlError(f"not YAML: {' '.join(str(error).split())}") from None


def dump_yaml(content: Any, flow: bool | None = False) -> str:
    """Returns the text of mappings, lists, numbers and texts; ROS reads each text as text, as it is quoted."""
    options = {"sort_keys": False, "default_flow_style": flow, "width": WIDTH, "allow_unicode": True}
    return yaml.dump(content, Dumper=_Dumper, **options)


class _Loader(yaml.SafeLoader):
    """Reads plain text as ROS does."""

    yaml_implicit_resolvers: dict[Any, Any] = {}  # noqa: RUF012  # the library's own form


class _Dumper(yaml.SafeDumper):
    """Quotes every text that is a value, and leaves keys as they are."""

    def represent_mapping(self, tag: str, mapping: Any, flow_style: bool | None = None) -> yaml.MappingNode:
        node = super().represent_mapping(tag, mapping, flow_style)
        for key, value in node.value:
            key.style = None
            for each in value.value if isinstance(value, yaml.SequenceNode) else (value,):
                if each.tag == f"{_TAG}str":
                    each.style = '"'
        return node


for kind, form in _PLAIN.items():
    _Loader.add_implicit_resolver(f"{_TAG}{kind}", re.compile(rf"(?:{form})$"), None)
for short in "yn":
    _Loader.bool_values = _Loader.bool_values | {short: short == "y"}


def _count(node: yaml.Node, as_ros: bool, seen: dict[yaml.Node, int]) -> int:
    """Number of values below a node with its aliases written out."""
    if node in seen:
        if as_ros or not seen[node]:
            raise YamlError(f"line {node.start_mark.line + 1}: got an alias of this value, expected the value itself")
        return seen[node]
    seen[node] = 0
    total = 1
    for each in _children(node):
        total += _count(each, as_ros, seen)
    if total > MOST_NODES:
        raise YamlError(f"line {node.start_mark.line + 1}: got over {MOST_NODES} values by aliases, expected fewer")
    seen[node] = total
    return total


def _children(node: yaml.Node) -> Iterator[yaml.Node]:
    if isinstance(node, yaml.MappingNode):
        for pair in node.value:
            yield from pair
    elif isinstance(node, yaml.SequenceNode):
        yield from node.value


def _checked(node: yaml.Node, as_ros: bool) -> yaml.Node:
    """The same node, its mappings without a key given twice."""
    if isinstance(node, yaml.MappingNode):
        first: dict[Hashable, tuple[yaml.Node, yaml.Node]] = {}
        for key, value in node.value:
            name = key.value if isinstance(key, yaml.ScalarNode) else id(key)
            if isinstance(key, yaml.ScalarNode) and key.tag != f"{_TAG}merge":
                key.tag = f"{_TAG}str"
            if name not in first:
                first[name] = key, value
                continue
            before, held = first[name]
            if not (as_ros and isinstance(held, yaml.MappingNode) and isinstance(value, yaml.MappingNode)):
                where = f"line {key.start_mark.line + 1}: {key.value}"
                raise YamlError(f"{where}: given in line {before.start_mark.line + 1} already, expected it once")
            held.value += value.value
        node.value = list(first.values())
    for each in _children(node):
        _checked(each, as_ros)
    return node
