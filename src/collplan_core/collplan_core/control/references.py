"""q_bound and q_flow, the references of the contact maneuvers, and the switch phi to them from q_spl. Paper: III-B."""

import numpy as np

from collplan_core.command import FLOW_THROUGH
from collplan_core.jit import njit
from collplan_core.local_map.contact_point import ContactPoint, nearest_on_surface
from collplan_core.local_map.free_space import inside
from collplan_core.local_map.record import LocalMap


@njit
def _onto_boundary(
    border: np.ndarray, surface: np.ndarray, number: int, path: np.ndarray, first: int
) -> tuple[np.ndarray, int]:
    """The path (m, 2) with its samples from `first` on projected onto a surface, until one is in F; the index of that.

    Where none is, the index is the last. Relative to the centre of F [m].
    """
    projected = path.copy()
    i = first
    while i < len(path) and not inside(border, path[i, 0], path[i, 1]):
        projected[i, 0], projected[i, 1] = nearest_on_surface(border, surface, number, path[i, 0], path[i, 1])
        i += 1
    return projected, min(i, len(path) - 1)


def boundary_reference(path: np.ndarray, contact: ContactPoint, local_map: LocalMap) -> tuple[np.ndarray, np.ndarray]:
    """q_bound: the reference (n, 2) with what lies beyond the boundary projected onto it.

    Returns:
        the projected reference (n, 2) and the disengaging point p_d (2,), where the projection ends.
    """
    center = local_map.position
    projected, last = _onto_boundary(local_map.border, local_map.surface, contact.surface, path - center, contact.index)
    return projected + center, projected[last] + center


def flow_reference(path: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """q_flow: the reference (n, 2) projected onto its chord WP_4 - WP_1, and the chord's end (2,)."""
    chord = path[-1] - path[0]
    length2 = max(float(chord @ chord), 1e-18)
    return path[0] + np.outer((path - path[0]) @ chord / length2, chord), path[-1]


def maneuver_reference(
    maneuver: str, path: np.ndarray, contact: ContactPoint, local_map: LocalMap
) -> tuple[np.ndarray, np.ndarray]:
    """The reference of a contact maneuver and the point where it is released."""
    return flow_reference(path) if maneuver == FLOW_THROUGH else boundary_reference(path, contact, local_map)


WAITING, ENGAGED, RELEASED = "waiting", "engaged", "released"


def update_engaged(
    stage: str, position: np.ndarray, contact_point: np.ndarray, release_point: np.ndarray, switch_distance: float
) -> str:
    """phi: engages within delta of p_c, releases within delta of p_d, and does not engage twice for one contact."""
    if stage == WAITING and float(np.hypot(*(position - contact_point))) <= switch_distance:
        return ENGAGED
    near_release = float(np.hypot(*(position - release_point))) <= switch_distance
    passed = float((position - release_point) @ (release_point - contact_point)) >= 0.0
    return RELEASED if stage == ENGAGED and near_release and passed else stage
