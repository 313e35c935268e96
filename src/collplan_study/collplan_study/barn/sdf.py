"""Worlds in SDF, the format of Gazebo: the solid shapes of its models, seen from above.

In a file that lists models under both `world` and `state`, shapes are read from `world` and poses from `state`, as
Gazebo does. Every model is taken as static, whatever `static` says, and as tall as the robot or taller. Content that
could change the obstacles and is not supported (meshes, includes, nested models, other frames, ...) is an error.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from collplan_core.worlds import World, WorldError
from collplan_study.barn.xml_file import GZIP, attributes, line_of, read_xml

MARGIN = 1.0
"""Distance from obstacles, start and goal to the bounds [m]; the bounds are no walls."""

GROUND = ("plane", "empty")
"""Shapes that are no obstacles."""
HARMLESS_MODELS = ("model://ground_plane", "model://sun")

_UPRIGHT = 1e-4
"""Largest deviation from 1 of the third direction cosine of an upright shape: a tilt of 0.8 degrees."""


def is_sdf(path: Path) -> bool:
    """Whether a path is a world in SDF: by its suffix, or as its file is compressed or begins as XML does."""
    if {".sdf", ".world"} & set(path.suffixes):
        return True
    if not path.is_file():
        return False
    with path.open("rb") as file:
        first_bytes = file.read(64)
    return first_bytes.startswith(GZIP) or first_bytes.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<")


def load_sdf(path: Path, start: np.ndarray, goal: np.ndarray, scale: float = 1.0) -> World:
    """The world in an SDF file, gzip-compressed or not, named after the file.

    Args:
        path: path of the file.
        start, goal: (2,) in the frame of the file, before scaling [m].
        scale: factor on all coordinates and sizes, those of start and goal included.

    Raises:
        WorldError: the file cannot be read, is hostile, holds no obstacle or unsupported content, or start or goal lie
            in an obstacle. The message names the file and, if known, the line.
    """
    if not (isfinite(scale) and scale > 0.0):
        raise WorldError(f"scale: got {scale:g}, expected a number above 0")
    shapes = list(_shapes(path, _world_element(path)))
    if not shapes:
        raise WorldError(f"{path}: holds no obstacles, expected models with cylinders, boxes or spheres that collide")
    circles = np.array([s for s in shapes if s.shape == (3,)]).reshape(-1, 3) * scale
    boxes = tuple(s * scale for s in shapes if s.shape == (4, 2))
    ends = np.asarray(start, dtype=float) * scale, np.asarray(goal, dtype=float) * scale
    try:
        return World(_name(path), boxes, circles, _bounds(boxes, circles, ends), False, *ends)
    except WorldError as error:
        raise WorldError(f"{path}: {error}") from None


@dataclass(frozen=True)
class _Collision:
    """One `collision` element of a link.

    Attributes:
        path: path of the file; model: name of its model; both for error messages.
        pose: (4, 4) pose of the shape in the world.
        element: the XML element.
    """

    path: Path
    model: str
    pose: np.ndarray
    element: Element

    def error(self, element: Element, message: str) -> WorldError:
        return WorldError(f"{self.path}:{line_of(element)}: model {self.model!r}: {message}")


def _name(path: Path) -> str:
    return path.name.removesuffix(".gz").removesuffix(".world").removesuffix(".sdf")


def _world_element(path: Path) -> Element:
    root = read_xml(path)
    if root.tag != "sdf":
        raise WorldError(f"{path}:{line_of(root)}: got <{root.tag:.40}>, expected <sdf>")
    worlds = root.findall("world")
    if len(worlds) != 1:
        raise WorldError(f"{path}: got {len(worlds)} worlds, expected <sdf> with one <world>")
    return worlds[0]


def _shapes(path: Path, world: Element) -> Iterator[np.ndarray]:
    """Circles (3,) x, y, radius and corners of boxes (4, 2) [m], in the order of the file."""
    _refuse_additions(path, world)
    states = {model.get("name"): model for model in world.iterfind("state/model")}
    for model in world.iterfind("model"):
        for collision in _collisions(path, model, states.get(model.get("name"))):
            shape = _shape(collision)
            if shape is not None:
                yield shape


def _refuse_additions(path: Path, world: Element) -> None:
    for tag in ("include", "population", "state/insertions", "state/deletions", "model/model", "model/include"):
        for element in world.iterfind(tag):
            if (element.findtext("uri") or "").strip() not in HARMLESS_MODELS:
                expected = "expected models with their shapes in this file"
                raise WorldError(f"{path}:{line_of(element)}: {tag}: not supported, {expected}")


def _collisions(path: Path, model: Element, state: Element | None) -> Iterator[_Collision]:
    name = model.get("name", "")
    at_model = _pose(path, model if state is None or state.find("pose") is None else state)
    for link in model.iterfind("link"):
        # poses of links in a state are those in the world, not in the model
        moved = None if state is None else _named(state, link.get("name"))
        at_link = at_model @ _pose(path, link) if moved is None else _pose(path, moved)
        for collision in link.iterfind("collision"):
            yield _Collision(path, name, at_link @ _pose(path, collision), collision)
    if state is not None:
        _refuse_scaled(path, name, state)


def _named(state: Element, name: str | None) -> Element | None:
    links = (link for link in state.iterfind("link") if link.get("name") == name)
    return next((link for link in links if link.find("pose") is not None), None)


def _refuse_scaled(path: Path, name: str, state: Element) -> None:
    scale = state.find("scale")
    if scale is not None and (_numbers(path, scale, 3) != 1.0).any():
        raise WorldError(f"{path}:{line_of(scale)}: model {name!r}: got scale {scale.text!r}, expected 1 1 1")


def _shape(collision: _Collision) -> np.ndarray | None:
    geometry = collision.element.find("geometry")
    kinds = [] if geometry is None else list(geometry)
    if len(kinds) != 1:
        raise collision.error(collision.element, f"collision with {len(kinds)} shapes, expected one")
    kind = kinds[0]
    if kind.tag in GROUND:
        return None
    if kind.tag not in SHAPES:
        raise collision.error(kind, f"{kind.tag}: not supported, expected {', '.join((*SHAPES, *GROUND))}")
    if kind.tag != "sphere" and abs(collision.pose[2, 2]) < 1.0 - _UPRIGHT:
        raise collision.error(kind, f"{kind.tag}: lies tilted, expected one that stands upright")
    return SHAPES[kind.tag](collision, kind)


def _circle(collision: _Collision, kind: Element) -> np.ndarray:
    (radius,) = _sizes(collision, kind, "radius", 1)
    return np.array([*collision.pose[:2, 3], radius])


def _box(collision: _Collision, kind: Element) -> np.ndarray:
    length, width, _ = _sizes(collision, kind, "size", 3)
    corners = np.array([[-length, -width], [length, -width], [length, width], [-length, width]]) / 2
    return collision.pose[:2, 3] + corners @ collision.pose[:2, :2].T


SHAPES = {"cylinder": _circle, "box": _box, "sphere": _circle}
"""Supported shapes by tag: the function that reads each."""


def _sizes(collision: _Collision, kind: Element, tag: str, count: int) -> np.ndarray:
    element = kind.find(tag)
    if element is None:
        raise collision.error(kind, f"{kind.tag}: {tag} is missing")
    sizes = _numbers(collision.path, element, count)
    if not (sizes > 0.0).all():
        raise collision.error(element, f"{kind.tag}: got {tag} {element.text!r}, expected more than 0 [m]")
    return sizes


def _pose(path: Path, element: Element) -> np.ndarray:
    """The `pose` of an element as a matrix (4, 4); the identity without one."""
    from scipy.spatial.transform import Rotation

    matrix = np.eye(4)
    pose = element.find("pose")
    if pose is None:
        return matrix
    other = {name: value for name, value in attributes(pose).items() if value}
    if other:
        raise WorldError(f"{path}:{line_of(pose)}: pose: got {other}, expected one in the frame of its parent, radians")
    x, y, z, *angles = _numbers(path, pose, 6)
    matrix[:3, :3] = Rotation.from_euler("xyz", angles).as_matrix()
    matrix[:3, 3] = x, y, z
    return matrix


def _numbers(path: Path, element: Element, count: int) -> np.ndarray:
    try:
        numbers = np.array([float(word) for word in (element.text or "").split()])
    except ValueError:
        numbers = np.array([])
    if len(numbers) != count or not np.isfinite(numbers).all():
        got = f"got {element.text or ''!r:.80}"
        raise WorldError(f"{path}:{line_of(element)}: {element.tag}: {got}, expected {count} finite numbers")
    return numbers


def _bounds(
    boxes: tuple[np.ndarray, ...], circles: np.ndarray, ends: tuple[np.ndarray, ...]
) -> tuple[float, float, float, float]:
    reach = circles[:, 2:]
    points = np.vstack([*boxes, circles[:, :2] - reach, circles[:, :2] + reach, *ends])
    return (*(points.min(axis=0) - MARGIN).tolist(), *(points.max(axis=0) + MARGIN).tolist())
