"""Maps in the form of ROS's map_server: a YAML file and a grey image, whose occupied cells become rectangles.

    image: lab.pgm              # from the file's folder on; PGM, PNG or BMP
    mode: trinary               # optional; or scale, which has the same occupied cells
    resolution: 0.05            # side of a cell [m]
    origin: [-2.0, -3.0, 0]     # x, y [m] of the lower left corner, and yaw, which must be 0
    negate: 0                   # 1: white is occupied, not black
    occupied_thresh: 0.65       # a cell is occupied where its occupancy, from 0 to 1, is not less
    free_thresh: 0.25

All other cells, unknown ones too, are free. `name`, `walled`, `start` and `goal` are those of a world file; map_server
does not read them. Nothing stands at the edges of the image unless `walled` is true.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.worlds.keys import check_keys, numbers
from collplan_core.worlds.shapes import WorldError

REQUIRED = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
OF_WORLD_FILE = ("name", "walled", "start", "goal")
MODES = ("trinary", "scale")
GREY = ("1", "L", "P", "RGB")
"""Kinds of images, as Pillow calls them, whose grey values are of 8 bits and have no transparency."""
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
    if yaw != 0.0:
        raise WorldError(f"origin: got yaw {yaw:g}, expected 0: turn the image")
    threshold, _ = (_share(key, mapping[key]) for key in ("occupied_thresh", "free_thresh"))
    shades = _shades(folder / str(mapping["image"]))
    found = rectangles_of((shades if mapping["negate"] else 1.0 - shades) >= threshold)
    # rounded, so that a file written of them is short
    corners = np.round(np.tile(corner, 2) + side * found, 6)[:, [[0, 1], [2, 1], [2, 3], [0, 3]]]
    bounds = np.round([*corner, *(np.array(corner) + side * np.array(shades.shape[::-1]))], 6)
    kept = {key: mapping[key] for key in OF_WORLD_FILE if key in mapping}
    return {"bounds": bounds.tolist(), "walled": False, "polygons": corners.tolist(), **kept}


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


def _shades(path: Path) -> np.ndarray:
    """Shades (h, w) of an image, 0 for black to 1 for white, the lowest row first."""
    # takes long to load
    from PIL import Image

    try:
        with Image.open(path, formats=("PPM", "PNG", "BMP")) as image:
            mode, shades = image.mode, np.asarray(image.convert("L"))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise WorldError(f"image: {path}: cannot be read ({error}), expected a PGM, PNG or BMP file") from None
    if mode not in GREY:
        raise WorldError(f"image: {path}: got a {mode} image, expected grey values of 8 bits, none transparent")
    return shades[::-1] / 255.0
