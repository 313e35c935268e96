"""Predicted boundaries E: where an observed boundary goes on into unseen space. Paper: II-A, set E.

A boundary is seen to go on at the far end of a shadow edge (behind the occluder) and where the map border cuts it. At
the near end of a shadow edge a convex obstacle turns away, and its tangent there points into free space.
"""

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import BORDER


@njit
def find_predicted(
    reach: np.ndarray, ends: np.ndarray, surface: np.ndarray, normals: np.ndarray, jumps: np.ndarray
) -> np.ndarray:
    """(e, 4) half lines: origin relative to the centre of the star, unit tangent into unseen space."""
    n = len(reach)
    found = np.empty((2 * n, 4))
    count = 0
    for k in range(n):
        j = (k + 1) % n
        jump = jumps[k]
        far_k = surface[k] >= 0 and ((jump and reach[k] > reach[j]) or (not jump and surface[j] == BORDER))
        far_j = surface[j] >= 0 and ((jump and reach[j] > reach[k]) or (not jump and surface[k] == BORDER))
        for far, i, onward in ((far_k, k, 1.0), (far_j, j, -1.0)):
            if not far:
                continue
            tx, ty = -normals[i, 1], normals[i, 0]
            # onward = 1 continues counter-clockwise around the centre, against which an outward normal's left turn goes
            x, y = ends[i]
            if (x * ty - y * tx) * onward < 0.0:
                tx, ty = -tx, -ty
            found[count, 0], found[count, 1], found[count, 2], found[count, 3] = x, y, tx, ty
            count += 1
    return found[:count]
