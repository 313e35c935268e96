"""q_bound and q_flow, the references of the contact maneuvers, and the switch phi to them from q_spl. Paper: III-B."""

import math

import numpy as np

from collplan_core.command import FLOW_THROUGH
from collplan_core.control.tracking import saturate
from collplan_core.local_map.contact_point import SAME_POINT, ContactPoint
from collplan_core.local_map.free_space import sector
from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Settings

GOES_ON = 10.0
"""A boundary is taken to go straight on beyond what was seen of it for so long [m]."""


def _seen_of_boundary(contact: ContactPoint, local_map: LocalMap, extension: float) -> np.ndarray:
    """Boundary seen at a contact, continued along its tangents: (m, 2), counter-clockwise [m]."""
    x, y = contact.point - local_map.position
    n = len(local_map.surface)
    order = (sector(x, y, n) + 1 + np.arange(-n // 2, n // 2)) % n
    order = order[local_map.surface[order] == contact.surface]
    line = local_map.border_points[order]
    tangents = extension * local_map.normals[order[[0, -1]]] @ np.array([[0.0, -1.0], [1.0, 0.0]])
    return np.vstack([line[0] - tangents[0], line, line[-1] + tangents[1]])


def _projected(line: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Arc lengths (n,) on a line (m, 2) nearest to points (n, 2) [m]; and which points are left of an end piece."""
    begin, piece = line[:-1], np.diff(line, axis=0)
    length = np.hypot(*piece.T)
    share = ((points[:, None] - begin) * piece).sum(axis=2) / np.maximum(length, SAME_POINT) ** 2
    away = points[:, None] - begin - np.clip(share, 0.0, 1.0)[..., None] * piece
    k, each = (away**2).sum(axis=2).argmin(axis=1), np.arange(len(points))
    left = piece[k, 0] * away[each, k, 1] - piece[k, 1] * away[each, k, 0] > 0.0
    along = (length.cumsum() - length)[k] + np.clip(share[each, k], 0.0, 1.0) * length[k]
    return along, left & ((k == 0) | (k == len(piece) - 1))


def boundary_reference(
    times: np.ndarray, path: np.ndarray, contact: ContactPoint, local_map: LocalMap, settings: Settings
) -> tuple[np.ndarray, np.ndarray]:
    """q_bound: the reference (n, 2) at its times (n,) with what lies beyond the boundary projected onto it.

    It ends with the first sample in F again or, past what was seen of the boundary, in front of where that goes on
    straight. No step of what is projected, nor of the way back from it to the reference, is faster than v_max.

    Returns:
        the projected reference (n, 2) and the disengaging point p_d (2,) on the boundary, where the projection ends.
    """
    first, printed = contact.index, settings.controller.boundary_projection == "printed"
    line = _seen_of_boundary(contact, local_map, 0.0 if printed else GOES_ON)
    foot, in_front = _projected(line, np.vstack([path, contact.point]))
    back = (local_map.contains(path) | in_front[:-1])[first:]
    end = first + int(back.argmax()) if back.any() else len(path)
    longest = np.diff(times, prepend=-math.inf) * (math.inf if printed else settings.robot.max_speed)
    longest[first] *= max(1.0 - contact.share, SAME_POINT)
    result, along, length = path.copy(), foot[-1], np.append(0.0, np.hypot(*np.diff(line, axis=0).T).cumsum())
    for i in range(first, end):
        along += np.clip(foot[i] - along, -longest[i], longest[i])
        result[i] = [np.interp(along, length, line[:, axis]) for axis in range(2)]
    for i in range(end, len(path)):
        result[i] = result[i - 1] + saturate(path[i] - result[i - 1], longest[i])
    return result, result[end - 1]


def flow_reference(path: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """q_flow: the reference (n, 2) projected onto its chord WP_4 - WP_1, and the chord's end (2,)."""
    chord = path[-1] - path[0]
    length2 = max(float(chord @ chord), 1e-18)
    return path[0] + np.outer((path - path[0]) @ chord / length2, chord), path[-1]


def maneuver_reference(
    maneuver: str, times: np.ndarray, path: np.ndarray, contact: ContactPoint, local_map: LocalMap, settings: Settings
) -> tuple[np.ndarray, np.ndarray]:
    """The reference of a contact maneuver and the point where it is released."""
    if maneuver == FLOW_THROUGH:
        return flow_reference(path)
    return boundary_reference(times, path, contact, local_map, settings)


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
