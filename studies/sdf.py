"""Worlds in SDF, the format of Gazebo, as world files of this project: the solid shapes of models, seen from above.

    .venv/bin/python studies/sdf.py maze.world --start 0 0 --goal 5 0 --out runs/maze.yaml

In a file that lists models under both `world` and `state`, shapes are read from `world` and poses from `state`, as
Gazebo does. Every model is taken as standing still. Shapes that end at the ground or begin above `--height` are left
out; the program says how many, and which joints and plugins it ignores. An element that could hold or move an obstacle
and is not supported (meshes, includes, actors, nested models, other frames, unknown elements, ...) is an error.
"""

import argparse
import gzip
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from lxml import etree
from scipy.spatial.transform import Rotation

from collplan_core.worlds import World, WorldError, save_world

MARGIN = 1.0
"""Distance from obstacles, start and goal to the bounds [m]; the bounds are no walls."""
HEIGHT = 0.5
"""Height above which a robot passes below a shape, unless another one is given [m]."""
GROUND = 1e-3
"""Height up to which a shape belongs to the ground [m]."""
HARMLESS_MODELS = ("ground_plane", "sun")
"""Included models that hold no obstacle, from whatever address."""
_ANY = "pose plugin frame"
HARMLESS = {
    "world": f"{_ANY} model state include light scene physics gravity gui audio wind magnetic_field atmosphere road "
    "spherical_coordinates joint",
    "state": "model light sim_time real_time wall_time iterations",
    "model": f"{_ANY} include link joint static self_collide allow_auto_disable enable_wind gripper scale",
    "link": f"{_ANY} collision visual sensor inertial gravity enable_wind self_collide kinematic must_be_base_link "
    "velocity_decay velocity acceleration wrench audio_sink audio_source battery light particle_emitter projector",
    "collision": f"{_ANY} geometry surface laser_retro max_contacts density auto_inertia_params",
}
"""Names of the elements that are read, or hold and move no obstacle, within each."""
UPRIGHT = 1e-4
"""Largest deviation from 1 of the third direction cosine of an upright shape: a tilt of 0.8 degrees."""
GZIP = b"\x1f\x8b"
"""First bytes of a gzip file."""
LARGEST = 16 * 2**20
"""Largest file, unpacked [bytes]; a world of 345 cylinders has 0.7 million."""


class _Solid(NamedTuple):
    """An obstacle seen from above, and its model: a circle (3,) x, y, radius or the corners (4, 2) of a box [m]."""

    model: str
    shape: np.ndarray
    bottom: float
    top: float


def load_sdf(
    path: Path,
    start: Sequence[float],
    goal: Sequence[float],
    scale: float = 1.0,
    height: float = HEIGHT,
    say: Callable[[str], None] = print,
) -> World:
    """The world in an SDF file, gzip-compressed or not, named after the file.

    Start and goal are x, y in the frame of the file, before scaling [m]; `scale` is a factor on all coordinates and
    sizes, theirs included. Shapes that begin above `height` are left out, before scaling [m]. `say` takes a sentence on
    what was left out or ignored.

    Raises:
        WorldError: the file cannot be read, holds no obstacle or unsupported content, or start or goal lie in an
            obstacle. The message names the file and, if known, the line.
    """
    if not 0.0 < scale < np.inf:
        raise WorldError(f"scale: got {scale:g}, expected a number above 0")
    world = _world_element(path)
    _check_elements(path, world)
    found = [solid for solid in _solids(path, world) if solid.top > GROUND]
    solids = [solid for solid in found if solid.bottom <= height]
    if not solids:
        raise WorldError(
            f"{path}: holds no obstacles up to {height:g} m, expected cylinders, boxes or spheres that collide"
        )
    for sentence in (*_above(found, height), *_ignored(world)):
        say(f"{path}: {sentence}")
    round_ones = [solid for solid in solids if solid.shape.shape == (3,)]
    edged_ones = [solid for solid in solids if solid.shape.shape == (4, 2)]
    circles = np.array([solid.shape for solid in round_ones]).reshape(-1, 3) * scale
    boxes = tuple(solid.shape * scale for solid in edged_ones)
    ends = np.asarray(start, dtype=float) * scale, np.asarray(goal, dtype=float) * scale
    points = np.vstack([*boxes, circles[:, :2] - circles[:, 2:], circles[:, :2] + circles[:, 2:], *ends])
    (x0, y0), (x1, y1) = (points.min(axis=0) - MARGIN).tolist(), (points.max(axis=0) + MARGIN).tolist()
    try:
        return World(path.name.partition(".")[0], boxes, circles, (x0, y0, x1, y1), False, *ends)
    except WorldError as error:
        models = {"circles": round_ones, "polygons": edged_ones}
        named = re.sub(r"(circles|polygons)\[(\d+)\]", lambda m: f"model {models[m[1]][int(m[2])].model!r}", str(error))
        raise WorldError(f"{path}: {named}") from None


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
    if len(root) > 1:
        raise _wrong(path, next(each for each in root if each is not worlds[0]), "beside <world>, expected it alone")
    return worlds[0]


def _check_elements(path: Path, world: etree._Element) -> None:
    """Raises WorldError on an element that could hold a shape or move one, and is not read."""
    for parent in world.iter(*HARMLESS):
        inside = {each.tag for each in parent.iterancestors()}
        if inside & {"visual", "sensor", "gui", "plugin", "light"}:
            continue
        for element in parent:
            tag = element.tag
            if isinstance(tag, str) and tag not in HARMLESS[parent.tag].split() and "}" not in tag:
                raise _wrong(path, element, "not supported, expected models with their shapes in this file")
            if tag == "include" and _included(element) not in HARMLESS_MODELS:
                raise _wrong(
                    path, element, f"uri {element.findtext('uri')!r:.200} is another file, expected its shapes here"
                )
        if parent.get("placement_frame"):
            raise _wrong(path, parent, f"placement_frame: got {parent.get('placement_frame')!r:.80}, expected none")


def _included(element: etree._Element) -> str:
    """Name of the model that an include names, from this machine or from a server."""
    parts = (element.findtext("uri") or "").strip().lower().replace("%20", "_").replace(" ", "_").rstrip("/").split("/")
    after = [part for before, part in pairwise(parts) if before == "models"]
    return after[0] if after else parts[-1]


def _above(found: Sequence[_Solid], height: float) -> Iterator[str]:
    above = [solid for solid in found if solid.bottom > height]
    if above:
        names = ", ".join(sorted({solid.model for solid in above}))
        yield f"{len(above)} of {len(found)} shapes begin above {height:g} m and are left out: {names:.200}"


def _ignored(world: etree._Element) -> Iterator[str]:
    moving = [joint.get("name") for joint in world.iterfind(".//joint") if joint.get("type") != "fixed"]
    plugins = [
        each.get("filename") or each.get("name") for each in world.xpath("plugin|model/plugin|model/link/plugin")
    ]
    for what, names in (
        ("joints are taken as fixed", moving),
        ("plugins are ignored, also if they move models", plugins),
    ):
        if names:
            yield f"{len(names)} {what}: {', '.join(sorted({str(name) for name in names})):.200}"


def _solids(path: Path, world: etree._Element) -> Iterator[_Solid]:
    """The shapes that collide, in the order of the file."""
    states = {model.get("name"): model for model in world.iterfind("state/model")}
    for model in world.iterfind("model"):
        for pose, collision in _collisions(path, model, states.get(model.get("name"))):
            solid = _solid(path, model.get("name") or "", pose, collision)
            if solid is not None:
                yield solid


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


def _solid(path: Path, model: str, pose: np.ndarray, collision: etree._Element) -> _Solid | None:
    """The shape of a collision; None for one that is the ground or empty."""
    kinds = collision.findall("geometry/*")
    if len(kinds) != 1:
        raise _wrong(path, collision, f"{len(kinds)} shapes, expected one")
    (kind,) = kinds
    if kind.tag == "empty":
        return None
    if kind.tag == "plane":
        normal = pose[:3, :3] @ _numbers(path, given, 3) if (given := kind.find("normal")) is not None else pose[:3, 2]
        if normal[2] < (1.0 - UPRIGHT) * np.linalg.norm(normal) or pose[2, 3] > GROUND:
            raise _wrong(path, kind, "is no ground, expected one that looks up, at height 0 or below")
        return None
    if kind.tag not in ("cylinder", "box", "sphere"):
        raise _wrong(path, kind, "not supported, expected cylinder, box or sphere")
    if kind.tag != "sphere" and abs(pose[2, 2]) < 1.0 - UPRIGHT:
        raise _wrong(path, kind, "lies tilted, expected one that stands upright")
    names = {"box": (("size", 3),), "cylinder": (("radius", 1), ("length", 1)), "sphere": (("radius", 1),)}[kind.tag]
    sizes = np.concatenate([_sizes(path, kind, name, count) for name, count in names])
    half = sizes[0] if kind.tag == "sphere" else sizes[-1] / 2
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * sizes[:2] / 2 if kind.tag == "box" else None
    shape = np.array([*pose[:2, 3], sizes[0]]) if corners is None else pose[:2, 3] + corners @ pose[:2, :2].T
    return _Solid(model, shape, pose[2, 3] - half, pose[2, 3] + half)


def _sizes(path: Path, kind: etree._Element, name: str, count: int) -> np.ndarray:
    element = kind.find(name)
    if element is None:
        raise _wrong(path, kind, f"{name} is missing")
    sizes = _numbers(path, element, count)
    if not (sizes > 0.0).all():
        raise _wrong(path, element, f"got {element.text!r}, expected more than 0 [m]")
    return sizes


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
    model = next((each.get("name") for each in (element, *element.iterancestors()) if each.tag == "model"), None)
    return WorldError(f"{path}:{element.sourceline}: {f'model {model!r}: ' if model else ''}{element.tag}: {message}")


def main(args: Sequence[str] | None = None) -> int:
    """Writes the world file; exit code 2 where the SDF file cannot be used."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, help="SDF file, gzip-compressed or not")
    parser.add_argument("--start", type=float, nargs=2, metavar=("X", "Y"), required=True, help="[m], before scaling")
    parser.add_argument("--goal", type=float, nargs=2, metavar=("X", "Y"), required=True, help="[m], before scaling")
    parser.add_argument("--scale", type=float, default=1.0, help="factor on all lengths (default 1)")
    parser.add_argument("--height", type=float, default=HEIGHT, help="leave out what begins above [m] (default 0.5)")
    parser.add_argument("--out", type=Path, required=True, help="world file to be written, .yaml")
    given = parser.parse_args(args)
    try:
        save_world(load_sdf(given.file, given.start, given.goal, given.scale, given.height), given.out)
    except WorldError as error:
        print(f"sdf: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
