"""The polygon that goals and robot must be in, given as a flat list of its corners' coordinates."""

from functools import lru_cache

import numpy as np
import shapely

FORM = "expected x, y, x, y, ... [m] of at least 3 corners of a polygon whose sides do not cross, or nothing"


def why_no_polygon(fence: tuple[float, ...]) -> str:
    """Returns why x, y, x, y, ... [m] are not the corners of a polygon; "" where they are, or where there are none."""
    if not fence:
        return ""
    if len(fence) % 2 or len(fence) < 6:
        return FORM
    polygon = _polygon(fence)
    return "" if polygon.is_valid and polygon.area > 0.0 else FORM


def is_outside(fence: tuple[float, ...], position: np.ndarray) -> bool:
    """Returns whether a position (2,) [m] is outside the polygon of these corners; nothing is outside an empty one."""
    return bool(fence) and not shapely.intersects_xy(_polygon(fence), float(position[0]), float(position[1]))


@lru_cache(maxsize=4)
def _polygon(fence: tuple[float, ...]) -> shapely.Polygon:
    polygon = shapely.Polygon(np.reshape(fence, (-1, 2)))
    shapely.prepare(polygon)
    return polygon
