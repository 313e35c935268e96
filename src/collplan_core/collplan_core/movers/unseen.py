"""The edges of what a scan does not show, out of which something may come."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.plane import nearest_on_segment
from collplan_core.sight_lines import is_full_turn

NARROW = 0.1
"""Nothing comes out between two hits nearer to each other than this, nor out of a run of lost beams as narrow [m]."""
ON_WALL = 0.005
"""Two hits whose middle is so near to a straight piece of wall are of that wall [m]."""


@njit
def unseen_edges(
    view: np.ndarray, view_from: np.ndarray, view_beams: np.ndarray, walls: np.ndarray, farthest: float
) -> np.ndarray:
    """(m, 4) segments x0, y0, x1, y1 between what was seen to be free and what was not [m].

    They join the ends of neighbouring beams, unless these met one wall. Beams that measured nothing are left out where
    few; more of them are a sector that begins at the sensor. A beam that met nothing ends at the sensor's largest
    range, `farthest` [m]. The other arguments are fields of the local map.
    """
    n, step = len(view), view_from[3]
    ends, edges, m = np.empty((n, 4)), np.empty((2 * n, 4)), 0
    for i in range(n):
        bearing, x, y = view_from[2] + i * step, view_from[0], view_from[1]
        if len(view_beams) > 0:
            bearing, x, y = bearing + view_beams[i, 2], view_beams[i, 0], view_beams[i, 1]
        far = min(view[i], farthest)
        ends[i] = np.array([x + far * math.cos(bearing), y + far * math.sin(bearing), x, y])
    seen = np.flatnonzero(view > 0.0)
    closed = is_full_turn(n, step)
    for s in range(len(seen)):
        i, j = seen[s], seen[(s + 1) % len(seen)]
        apart = (j - i) % n if s + 1 == len(seen) else j - i
        wide = apart * step * min(view[i], view[j], farthest)
        if (apart > 1 and wide > NARROW) or (s + 1 == len(seen) and not closed):
            edges[m] = np.array([ends[i, 2], ends[i, 3], ends[i, 0], ends[i, 1]])
            edges[m + 1] = np.array([ends[j, 2], ends[j, 3], ends[j, 0], ends[j, 1]])
            m += 2
        elif not (math.isfinite(view[i]) and math.isfinite(view[j]) and _is_closed(ends[i], ends[j], walls)):
            edges[m] = np.array([ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1]])
            m += 1
    return edges[:m]


@njit
def _is_closed(a: np.ndarray, b: np.ndarray, walls: np.ndarray) -> bool:
    """Returns whether nothing comes out between two hits: too narrow, or of one wall."""
    if math.hypot(b[0] - a[0], b[1] - a[1]) < NARROW:
        return True
    x, y = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])
    for k in range(len(walls)):
        cx, cy = nearest_on_segment(walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3], x, y)
        if math.hypot(x - cx, y - cy) < ON_WALL:
            return True
    return False
