"""Worlds in SDF, the format of Gazebo, as world files of this project: the solid shapes of models, seen from above.

    .venv/bin/python studies/sdf.py maze.world --start 0 0 --goal 5 0 --out runs/maze.yaml

In a file that lists models under both `world` and `state`, shapes are read from `world` and poses from `state`, as
Gazebo does. Every model is taken as static, and as tall as the robot or taller. Content that could change the obstacles
and is not supported (meshes, includes, nested models, other frames, ...) is an error.
"""

import argparse
import gzip
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from lxml import etree
from scipy.spatial.transform import Rotation

from collplan_core.worlds import World, WorldError, save_world

MARGIN = 1.0
"""Distance from obstacles, start and goal to the bounds [m]; the bounds are no walls."""
GROUND = ("plane", "empty")
"""Shapes that are no obstacles."""
HARMLESS_MODELS = ("model://ground_plane", "model://sun")
UPRIGHT = 1e-4
"""Largest deviation from 1 of the third direction cosine of an upright shape: a tilt of 0.8 degrees."""
GZIP = b"\x1f\x8b"
"""First bytes of a gzip file."""
LARGEST = 16 * 2**20
"""Largest file, unpacked [bytes]; a world of 345 cylinders has 0.7 million."""


def load_sdf(path: Path, start: Sequence[float], goal: Sequence[float], scale: float = 1.0) -> World:
    """The world in an SDF file, gzip-compressed or not, named after the file.

    Args:
        path: path of the file.
        start, goal: x, y in the frame of the file, before scaling [m].
        scale: factor on all coordinates and sizes, those of start and goal included.

    Raises:
        WorldError: the file cannot be read, holds no obstacle or unsupported content, or start or goal lie in an
            obstacle. The message names the file and, if known, the line.
    """
    if not 0.0 < scale < np.inf:
        raise WorldError(f"scale: got {scale:g}, expected a number above 0")
    shapes = list(_shapes(path, _world_element(path)))
    if not shapes:
        raise WorldError(f"{path}: holds no obstacles, expected models with cylinders, boxes or spheres that collide")
    circles = np.array([s for s in shapes if s.shape == (3,)]).reshape(-1, 3) * scale
    boxes = tuple(s * scale for s in shapes if s.shape == (4, 2))
    ends = np.asarray(start, dtype=float) * scale, np.asarray(goal, dtype=float) * scale
    points = np.vstack([*boxes, circles[:, :2] - circles[:, 2:], circles[:, :2] + circles[:, 2:], *ends])
    (x0, y0), (x1, y1) = (points.min(axis=0) - MARGIN).tolist(), (points.max(axis=0) + MARGIN).tolist()
    try:
        return World(path.name.partition(".")[0], boxes, circles, (x0, y0, x1, y1), False, *ends)
    except WorldError as error:
        raise WorldError(f"{path}: {error}") from None


def _world_element(path: Path) -> etree._Element:
    # neither entities nor other files are read, whatever the file says
    parser = etree.XMLParser(resolve_entities=False, no_network=True, remove_comments=True)
    try:
        with path.open("rb") as file:
            compressed = file.read(2) == GZIP
        with gzip.open(path) if compressed else path.open("rb") as file:
            content = file.read(LARGEST + 1)
        root = etree.fromstring(content, parser)
    except (OSError, EOFError, etree.XMLSyntaxError) as error:
        raise WorldError(f"{path}: cannot be read as XML ({error})") from None
    if len(content) > LARGEST or root.getroottree().docinfo.doctype:
        raise WorldError(f"{path}: expected at most {LARGEST} bytes and no document type")
    worlds = root.findall("world")
    if root.tag != "sdf" or len(worlds) != 1:
        raise WorldError(f"{path}: got <{root.tag:.40}> with {len(worlds)} worlds, expected <sdf> with one <world>")
    return worlds[0]


def _shapes(path: Path, world: etree._Element) -> Iterator[np.ndarray]:
    """Circles (3,) x, y, radius and corners of boxes (4, 2) [m], in the order of the file."""
    for tag in ("include", "population", "state/insertions", "state/deletions", "model/model", "model/include"):
        for element in world.iterfind(tag):
            if (element.findtext("uri") or "").strip() not in HARMLESS_MODELS:
                raise _wrong(path, element, "not supported, expected models with their shapes in this file")
    states = {model.get("name"): model for model in world.iterfind("state/model")}
    for model in world.iterfind("model"):
        for pose, collision in _collisions(path, model, states.get(model.get("name"))):
            shape = _shape(path, pose, collision)
            if shape is not None:
                yield shape


def _collisions(
    path: Path, model: etree._Element, state: etree._Element | None
) -> Iterator[tuple[np.ndarray, etree._Element]]:
    """Each `collision` of a model with its pose (4, 4) in the world."""
    moved: dict[str | None, np.ndarray] = {}
    at_model = _pose(path, model)
    if state is not None:
        scale = state.find("scale")
        if scale is not None and (_numbers(path, scale, 3) != 1.0).any():
            raise _wrong(path, scale, f"got {scale.text!r}, expected 1 1 1")
        # poses of links in a state are those in the world, not in the model
        moved = {link.get("name"): _pose(path, link) for link in state.iterfind("link[pose]")}
        at_model = at_model if state.find("pose") is None else _pose(path, state)
    for link in model.iterfind("link"):
        at_link = moved.get(link.get("name"), at_model @ _pose(path, link))
        for collision in link.iterfind("collision"):
            yield at_link @ _pose(path, collision), collision


def _shape(path: Path, pose: np.ndarray, collision: etree._Element) -> np.ndarray | None:
    kinds = collision.findall("geometry/*")
    if len(kinds) != 1:
        raise _wrong(path, collision, f"{len(kinds)} shapes, expected one")
    (kind,) = kinds
    if kind.tag in GROUND:
        return None
    if kind.tag not in ("cylinder", "box", "sphere"):
        raise _wrong(path, kind, "not supported, expected cylinder, box or sphere")
    if kind.tag != "sphere" and abs(pose[2, 2]) < 1.0 - UPRIGHT:
        raise _wrong(path, kind, "lies tilted, expected one that stands upright")
    name, count = ("size", 3) if kind.tag == "box" else ("radius", 1)
    element = kind.find(name)
    if element is None:
        raise _wrong(path, kind, f"{name} is missing")
    sizes = _numbers(path, element, count)
    if not (sizes > 0.0).all():
        raise _wrong(path, element, f"got {element.text!r}, expected more than 0 [m]")
    if kind.tag != "box":
        return np.array([*pose[:2, 3], sizes[0]])
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * sizes[:2] / 2
    return pose[:2, 3] + corners @ pose[:2, :2].T


def _pose(path: Path, element: etree._Element) -> np.ndarray:
    """The `pose` of an element as a matrix (4, 4); the identity without one."""
    matrix, pose = np.eye(4), element.find("pose")
    if pose is None:
        return matrix
    if any(pose.attrib.values()):
        raise _wrong(path, pose, f"got {dict(pose.attrib)}, expected one in the frame of its parent, radians")
    x, y, z, *angles = _numbers(path, pose, 6)
    matrix[:3, :3] = Rotation.from_euler("xyz", angles).as_matrix()
    matrix[:3, 3] = x, y, z
    return matrix


def _numbers(path: Path, element: etree._Element, count: int) -> np.ndarray:
    try:
        numbers = np.array([float(word) for word in (element.text or "").split()])
    except ValueError:
        numbers = np.array([])
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise _wrong(path, element, f"got {element.text or ''!r:.80}, expected {count} finite numbers")
    return numbers


def _wrong(path: Path, element: etree._Element, message: str) -> WorldError:
    model = next((each.get("name") for each in element.iterancestors("model")), None)
    return WorldError(f"{path}:{element.sourceline}: {f'model {model!r}: ' if model else ''}{element.tag}: {message}")


def main(args: Sequence[str] | None = None) -> int:
    """Writes the world file; exit code 2 where the SDF file cannot be used."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, help="SDF file, gzip-compressed or not")
    parser.add_argument("--start", type=float, nargs=2, metavar=("X", "Y"), required=True, help="[m], before scaling")
    parser.add_argument("--goal", type=float, nargs=2, metavar=("X", "Y"), required=True, help="[m], before scaling")
    parser.add_argument("--scale", type=float, default=1.0, help="factor on all lengths (default 1)")
    parser.add_argument("--out", type=Path, required=True, help="world file to be written, .yaml")
    given = parser.parse_args(args)
    try:
        save_world(load_sdf(given.file, given.start, given.goal, given.scale), given.out)
    except WorldError as error:
        print(f"sdf: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
