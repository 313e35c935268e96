"""Predicted boundaries E: where an observed boundary goes on into unseen space. Paper: II-A, set E.

A boundary is seen to go on at the far end of a shadow edge (behind the occluder) and where the map border cuts it. At
the near end of a shadow edge a convex obstacle turns away, and its tangent there points into free space.
"""

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import MAP_BORDER, FreeSpace


@njit
def find_predicted(free: FreeSpace, shadow: np.ndarray) -> np.ndarray:
    """(e, 4) the set E of half lines: origin relative to the centre of F, unit tangent e_i into unseen space."""
    reach, border, surface, normals, _ = free
    n = len(reach)
    found = np.empty((2 * n, 4))
    count = 0
    for k in range(n):
        j = (k + 1) % n
        goes_on_k = surface[k] >= 0 and (reach[k] > reach[j] if shadow[k] else surface[j] == MAP_BORDER)
        goes_on_j = surface[j] >= 0 and (reach[j] > reach[k] if shadow[k] else surface[k] == MAP_BORDER)
        for goes_on, i, onward in ((goes_on_k, k, 1.0), (goes_on_j, j, -1.0)):
            if not goes_on:
                continue
            tx, ty = -normals[i, 1], normals[i, 0]
            # the tangent (-n_y, n_x) runs clockwise around the centre; flip it where the boundary continues
            # counter-clockwise
            x, y = border[i]
            if (x * ty - y * tx) * onward < 0.0:
                tx, ty = -tx, -ty
            found[count, 0], found[count, 1], found[count, 2], found[count, 3] = x, y, tx, ty
            count += 1
    return found[:count]
