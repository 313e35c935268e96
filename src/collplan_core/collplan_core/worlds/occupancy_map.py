"""Maps in the form of ROS's map_server: a YAML file and a grey image, whose occupied cells become rectangles.

    image: lab.pgm              # from the file's folder on; PGM, PNG or BMP, opaque; of a colour the mean counts
    mode: trinary               # optional; or scale, which has the same occupied cells
    resolution: 0.05            # side of a cell [m]
    origin: [-2.0, -3.0, 0]     # x, y [m] of the lower left corner, and yaw, which must be 0
    negate: 0                   # 1: white is occupied, not black
    occupied_thresh: 0.65       # a cell is occupied where its occupancy, from 0 to 1, is more
    free_thresh: 0.25

All other cells, unknown ones too, are free. `name`, `walled`, `start` and `goal` are those of a world file; map_server
does not read them. Nothing stands at the edges of the image unless `walled` is true.
"""

import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.worlds.keys import check_keys, numbers
from collplan_core.worlds.shapes import WorldError

REQUIRED = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
OF_WORLD_FILE = ("name", "walled", "start", "goal")
MODES = ("trinary", "scale")
ALPHA = ("LA", "PA", "RGBA")
"""Kinds of images, as Pillow calls them, whose pixels have an opacity."""
KINDS = ("1", "L", "P", "RGB", *ALPHA)
"""Kinds of images whose channels have 8 bits."""
LEVEL = 1e-6
"""Largest yaw that counts as none [rad]."""
MOST_RECTANGLES = 4000


def as_world_file(mapping: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """The keys of a world file, from those of a map whose image is looked for from `folder` on.

    Raises:
        WorldError: a key or value that does not fit, an image that cannot be read, or too many rectangles.
    """
    check_keys(mapping, (*REQUIRED, "mode", *OF_WORLD_FILE), REQUIRED)
    if mapping.get("mode", "trinary") not in MODES:
        raise WorldError(f"mode: got {mapping['mode']!r:.80}, expected {' or '.join(MODES)}")
    if mapping["negate"] not in (0, 1):
        raise WorldError(f"negate: got {mapping['negate']!r:.80}, expected 0 or 1")
    (side,) = numbers("resolution", [mapping["resolution"]], 1, "expected a number above 0 [m]")
    if not 0.0 < side < np.inf:
        raise WorldError(f"resolution: got {side:g}, expected a number above 0 [m]")
    *corner, yaw = numbers("origin", mapping["origin"], 3, "expected [x, y, yaw] [m, rad]")
    if not np.isfinite(corner).all():
        raise WorldError(f"origin: got x {corner[0]:g}, y {corner[1]:g}, expected finite numbers [m]")
    if not np.isfinite(yaw):
        raise WorldError(f"origin: got yaw {yaw:g}, expected 0")
    if not abs(yaw) < LEVEL:
        raise WorldError(f"origin: got yaw {yaw:g}, expected 0: turn the image")
    threshold, _ = (_share(key, mapping[key]) for key in ("occupied_thresh", "free_thresh"))
    shades = _shades(folder / str(mapping["image"]), mapping.get("mode", "trinary"))
    found = rectangles_of((shades if mapping["negate"] else 1.0 - shades) > threshold)
    # rounded, so that a file written of them is short
    corners = np.round(np.tile(corner, 2) + side * found, 6)[:, [[0, 1], [2, 1], [2, 3], [0, 3]]]
    bounds = np.round([*corner, *(np.array(corner) + side * np.array(shades.shape[::-1]))], 6)
    kept = {key: mapping[key] for key in OF_WORLD_FILE if key in mapping}
    return {"bounds": bounds.tolist(), "walled": False, "polygons": corners.tolist(), **kept}


def in_words_of_map(error: str) -> str:
    """Returns a message on the polygons of a map, which nobody wrote, as one on its cells."""
    return re.sub(r"polygons\[\d+\]", "an occupied cell (negate, occupied_thresh?)", error)


def rectangles_of(occupied: np.ndarray) -> np.ndarray:
    """Rectangles (r, 4) of cells x0, y0, x1, y1 that cover every True cell of (h, w), row y and column x, and no other.

    Each is as large as it can be. Where two meet they overlap, without a seam that would stop a disc on its way along.

    Raises:
        WorldError: more than MOST_RECTANGLES.
    """
    steps = np.diff(np.pad(occupied, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    (rows, begins), ends = np.nonzero(steps == 1), np.nonzero(steps == -1)[1]
    order = np.lexsort((rows, ends, begins))
    runs = np.stack([begins, rows, ends], axis=1)[order]
    # a run below which the same columns are occupied, and no others beside them, goes on there
    first = np.flatnonzero((np.diff(runs, axis=0, prepend=[[-1, -1, -1]]) != [0, 1, 0]).any(axis=1))
    if len(first) > MOST_RECTANGLES:
        raise WorldError(
            f"image: got {len(first)} rectangles of occupied cells, expected at most {MOST_RECTANGLES}: "
            "remove speckles, or cut the map to a part"
        )
    before = np.cumsum(np.pad(occupied, ((0, 0), (1, 0))), axis=1, dtype=np.int32)
    found = set()
    for x0, row, x1 in runs[first].tolist():
        gaps = np.flatnonzero(before[:, x1] - before[:, x0] < x1 - x0)
        at = np.searchsorted(gaps, row)
        found.add((x0, int(gaps[at - 1]) + 1 if at else 0, x1, int(gaps[at]) if at < len(gaps) else len(occupied)))
    return np.array(sorted(found)).reshape(-1, 4)


def _share(key: str, value: Any) -> float:
    (share,) = numbers(key, [value], 1, "expected a number from 0 to 1")
    if not 0.0 <= share <= 1.0:
        raise WorldError(f"{key}: got {share:g}, expected a number from 0 to 1")
    return share


def _shades(path: Path, mode: str) -> np.ndarray:
    """Shades (h, w) of an image, 0 for black to 1 for white, the lowest row first."""
    # As in map_server a shade is the mean of the channels, in the mode trinary with opacity, where an image has one.
    # takes long to load
    from PIL import Image

    try:
        with warnings.catch_warnings(), Image.open(path, formats=("PPM", "PNG", "BMP")) as image:
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            if image.mode not in KINDS:
                raise WorldError(f"image: {path}: got a {image.mode} image, expected channels of 8 bits")
            layered = image.mode in ALPHA or "transparency" in image.info
            grey = image.mode in ("1", "L") and not layered
            channels = np.asarray(image.convert("L" if grey else "RGBA" if layered else "RGB"))
    except WorldError:
        raise
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise WorldError(f"image: {path}: cannot be read ({error}), expected a PGM, PNG or BMP file") from None
    if layered and channels[..., 3].min() < 255:
        raise WorldError(f"image: {path}: has transparent pixels, expected opaque ones")
    if not grey:
        channels = channels[..., : 4 if layered and mode == "trinary" else 3].mean(axis=2)
    return channels[::-1] / 255.0
