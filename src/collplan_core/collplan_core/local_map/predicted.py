"""Predicted boundaries E: where an observed boundary goes on into unseen space. Paper: II-A, set E.

An observed boundary meets a frontier at both ends of a shadow edge, and where the map border cuts it. It is seen to go
on at the far end of a shadow edge, behind the occluder, and at the map border. At the near end a convex obstacle turns
away, and its tangent there points into free space.
"""

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import MAP_BORDER, FreeSpace

AHEAD, BEHIND = 0, 1  # the counter-clockwise and the clockwise side of a direction


@njit
def _half_lines(free: FreeSpace, begins: np.ndarray) -> np.ndarray:
    """(e, 4) the tangents of the observed boundaries where, by direction and side (n, 2), a predicted one begins."""
    n = len(begins)
    found = np.empty((2 * n, 4))
    count = 0
    for k in range(n):
        for i, side, onward in ((k, AHEAD, 1.0), ((k + 1) % n, BEHIND, -1.0)):
            if not begins[i, side]:
                continue
            tx, ty = -free.normals[i, 1], free.normals[i, 0]
            # the tangent (-n_y, n_x) runs clockwise around the centre; flip it where the boundary continues
            # counter-clockwise
            x, y = free.border[i]
            if (x * ty - y * tx) * onward < 0.0:
                tx, ty = -tx, -ty
            found[count, 0], found[count, 1], found[count, 2], found[count, 3] = x, y, tx, ty
            count += 1
    return found[:count]


@njit
def where_boundaries_go_on(free: FreeSpace, shadow: np.ndarray) -> np.ndarray:
    """(e, 4) the set E as it is read: at far ends of shadow edges (n,), and where the map border cuts a boundary.

    Half lines: origin relative to the centre of F [m], unit tangent e_i into unseen space. Paper: II-A.
    """
    reach, surface = free.reach, free.surface
    n = len(reach)
    begins = np.zeros((n, 2), np.bool_)
    for k in range(n):
        j = (k + 1) % n
        begins[k, AHEAD] = surface[k] >= 0 and (reach[k] > reach[j] if shadow[k] else surface[j] == MAP_BORDER)
        begins[j, BEHIND] = surface[j] >= 0 and (reach[j] > reach[k] if shadow[k] else surface[k] == MAP_BORDER)
    return _half_lines(free, begins)


@njit
def where_boundaries_meet_frontiers(free: FreeSpace, shadow: np.ndarray) -> np.ndarray:
    """(e, 4) the set E as printed: wherever an observed boundary meets a frontier, both ends of shadow edges (n,).

    Half lines: origin relative to the centre of F [m], unit tangent e_i away from what was observed. Paper: II-A.
    """
    surface = free.surface
    n = len(surface)
    begins = np.zeros((n, 2), np.bool_)
    for k in range(n):
        j = (k + 1) % n
        begins[k, AHEAD] = surface[k] >= 0 and (shadow[k] or surface[j] == MAP_BORDER)
        begins[j, BEHIND] = surface[j] >= 0 and (shadow[k] or surface[k] == MAP_BORDER)
    return _half_lines(free, begins)


PREDICTED = {"going_on": where_boundaries_go_on, "printed": where_boundaries_meet_frontiers}
"""The set E by local_map.predicted."""
