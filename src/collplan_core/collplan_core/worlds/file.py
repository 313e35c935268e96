"""World files: YAML with bounds, obstacles, movers, start and goal.

All lengths are in metres, in the world frame:

    name: example            # optional, else the file's stem
    bounds: [0, 0, 2.4, 2.4] # x_min, y_min, x_max, y_max
    walled: true             # optional: the bounds are solid walls
    polygons:                # optional, each convex, corners in order
      - [[0.5, 0.0], [0.8, 0.0], [0.8, 1.0], [0.5, 1.0]]
    circles:                 # optional
      - {center: [1.5, 1.2], radius: 0.2}
    movers:                  # optional: discs and people that walk
      - {radius: 0.12, way: [[1.0, 0.3], [1.0, 2.0]], speed: 0.5}  # [m/s]; see `movers.Mover` for the optional keys
    start: [0.2, 0.2]        # optional
    goal: [2.2, 2.2]         # optional

A file with the key `image` is a map instead: see `occupancy_map`.
"""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.worlds.keys import check_keys, numbers
from collplan_core.worlds.movers import TIMES_FORM, WAY_FORM, Mover
from collplan_core.worlds.occupancy_map import as_world_file, in_words_of_map
from collplan_core.worlds.shapes import BOUNDS_FORM, MOST_OBSTACLES, POLYGON_FORM, World, WorldError
from collplan_core.yaml_text import YamlError, dump_yaml, parse_yaml, read_text

KEYS = ("name", "bounds", "walled", "polygons", "circles", "movers", "start", "goal")
MOVER_KEYS = tuple(field.name for field in fields(Mover))
CIRCLE_FORM = "expected {center: [x, y], radius: r} [m]"
POINT_FORM = "expected [x, y] [m]"


def read_world(path: Path) -> World:
    """The world in a YAML file.

    Raises:
        WorldError: the file is missing, cannot be read, is too large, is not YAML, or does not hold a world.
    """
    try:
        text = read_text(path)
    except YamlError as error:
        raise WorldError(f"{path}: {error}, expected a world file in YAML") from None
    return parse_text(text, str(path), path.stem, path.parent)


def parse_text(text: str, source: str, name: str, folder: Path = Path()) -> World:
    """The world that a YAML text holds; `source` stands in errors, `name` is used if the text names none.

    The image of a map is looked for from `folder` on.

    Raises:
        WorldError: not YAML, or not a world.
    """
    # before YAML is read, which takes a second for each 3,000: every circle has one
    circles = text.count("radius")
    if circles > MOST_OBSTACLES:
        raise WorldError(f"{source}: circles: got {circles}, expected at most {MOST_OBSTACLES}")
    try:
        mapping = parse_yaml(text)
    except YamlError as error:
        raise WorldError(f"{source}: {error}") from None
    if not isinstance(mapping, Mapping):
        raise WorldError(f"{source}: got {mapping!r:.80}, expected keys and values: {', '.join(KEYS)}")
    return parse_world({"name": name, **mapping}, source, folder)


def parse_world(mapping: Mapping[str, Any], source: str, folder: Path = Path()) -> World:
    """The world that a mapping with the keys of a world file, or of a map, describes; `source` stands in errors.

    Raises:
        WorldError: an unknown, missing or malformed key.
    """
    is_map = "image" in mapping
    try:
        if is_map:
            mapping = as_world_file(mapping, folder)
        check_keys(mapping, KEYS, required=("name", "bounds"))
        return World(
            name=_text("name", mapping["name"]),
            polygons=tuple(_polygon(f"polygons[{i}]", p) for i, p in enumerate(_entries(mapping, "polygons"))),
            circles=np.array([_circle(f"circles[{i}]", c) for i, c in enumerate(_entries(mapping, "circles"))]),
            bounds=_bounds(mapping["bounds"]),
            walled=_flag("walled", mapping.get("walled", True)),
            start=_point(mapping, "start"),
            goal=_point(mapping, "goal"),
            source=source,
            movers=tuple(_mover(f"movers[{i}]", m) for i, m in enumerate(_entries(mapping, "movers"))),
        )
    except WorldError as error:
        said = in_words_of_map(str(error)) if is_map else str(error)
        raise WorldError(f"{source}: {said}") from None


def save_world(world: World, path: Path) -> None:
    """Write a world so that reading it gives the same world, to the last bit.

    Raises:
        WorldError: the file cannot be written.
    """
    try:
        Path(path).write_text(world_text(world), encoding="utf-8")
    except OSError as error:
        raise WorldError(f"{path}: cannot be written ({error})") from None


def world_text(world: World) -> str:
    """Returns the text that `save_world` writes."""
    mapping: dict[str, Any] = {
        "name": world.name,
        "bounds": list(world.bounds),
        "walled": world.walled,
        "polygons": [corners.tolist() for corners in world.polygons],
        "circles": [{"center": [x, y], "radius": r} for x, y, r in world.circles.tolist()],
    }
    if world.movers:
        mapping["movers"] = [{key: _plain(getattr(mover, key)) for key in MOVER_KEYS} for mover in world.movers]
    ends = {"start": world.start, "goal": world.goal}
    mapping |= {key: point.tolist() for key, point in ends.items() if point is not None}
    return dump_yaml(mapping, flow=None)


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def _entries(mapping: Mapping[str, Any], key: str) -> list[Any]:
    entries = mapping.get(key)
    if entries is not None and not isinstance(entries, list):
        raise WorldError(f"{key}: got {entries!r:.80}, expected a list")
    return entries or []


def _bounds(value: Any) -> tuple[float, float, float, float]:
    x_min, y_min, x_max, y_max = numbers("bounds", value, 4, BOUNDS_FORM)
    return x_min, y_min, x_max, y_max


def _polygon(key: str, value: Any) -> np.ndarray:
    if not isinstance(value, list):
        raise WorldError(f"{key}: got {value!r:.80}, {POLYGON_FORM}")
    return np.array([numbers(f"{key}[{i}]", corner, 2, POINT_FORM) for i, corner in enumerate(value)])


def _circle(key: str, value: Any) -> list[float]:
    if not isinstance(value, Mapping) or set(value) != {"center", "radius"}:
        raise WorldError(f"{key}: got {value!r:.80}, {CIRCLE_FORM}")
    center = numbers(f"{key}.center", value["center"], 2, POINT_FORM)
    return [*center, *numbers(f"{key}.radius", [value["radius"]], 1, "expected a number above 0 [m]")]


def _mover(key: str, value: Any) -> Mover:
    if not isinstance(value, Mapping):
        raise WorldError(f"{key}: got {value!r:.80}, expected a mapping with the keys {', '.join(MOVER_KEYS)}")
    try:
        check_keys(value, MOVER_KEYS, required=("radius", "way", "speed"))
        if not isinstance(value["way"], list):
            raise WorldError(f"way: got {value['way']!r:.80}, {WAY_FORM}")
        way = [numbers(f"way[{i}]", point, 2, POINT_FORM) for i, point in enumerate(value["way"])]
        if value.get("times") is not None:
            numbers("times", value["times"], len(way), TIMES_FORM)
        return Mover(**{**value, "way": np.array(way).reshape(-1, 2)})
    except ValueError as error:
        raise WorldError(f"{key}.{error}") from None


def _point(mapping: Mapping[str, Any], key: str) -> np.ndarray | None:
    return None if mapping.get(key) is None else np.array(numbers(key, mapping[key], 2, POINT_FORM))


def _text(key: str, value: Any) -> str:
    if not isinstance(value, str) or not value:
        raise WorldError(f"{key}: got {value!r:.80}, expected text")
    return value


def _flag(key: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise WorldError(f"{key}: got {value!r:.80}, expected true or false")
    return value
