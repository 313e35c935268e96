"""Where the reference meets an observed boundary, and the maneuver for it. Paper: III-B, Alg. 3."""

import math
from dataclasses import dataclass

import numpy as np

from collplan_core.command import BOUNDARY_FOLLOWING, FLOW_THROUGH, FREE_SPACE
from collplan_core.jit import njit
from collplan_core.local_map.free_space import boundary_at, inside, sector
from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Control


@dataclass(frozen=True, eq=False)
class ContactPoint:
    """Where a reference first leaves F through an observed boundary, the engaging point p_c.

    Attributes:
        index: first sample of the reference beyond the boundary.
        share: where between the samples index - 1 and index, in [0, 1].
        point: (2,) position of the disc's centre there [m].
        direction: (2,) unit direction of the reference there.
        normal: (2,) unit normal out of the obstacle.
        surface: number of the observed surface in its map.
    """

    index: int
    share: float
    point: np.ndarray
    direction: np.ndarray
    normal: np.ndarray
    surface: int


@njit
def _first_exit(
    border: np.ndarray, surface: np.ndarray, shadow: np.ndarray, path: np.ndarray
) -> tuple[int, float, int]:
    """Sample at which the path leaves F through a boundary (-1: never), share of the last step, direction met.

    The path is relative to the centre of F.
    """
    for i in range(1, len(path)):
        if inside(border, path[i, 0], path[i, 1]):
            continue
        low, high = 0.0, 1.0
        for _ in range(20):
            middle = 0.5 * (low + high)
            x = path[i - 1, 0] + middle * (path[i, 0] - path[i - 1, 0])
            y = path[i - 1, 1] + middle * (path[i, 1] - path[i - 1, 1])
            if inside(border, x, y):
                low = middle
            else:
                high = middle
        x = path[i - 1, 0] + high * (path[i, 0] - path[i - 1, 0])
        y = path[i - 1, 1] + high * (path[i, 1] - path[i - 1, 1])
        k = boundary_at(surface, shadow, sector(x, y, len(border)))
        return (i, high, k) if k >= 0 else (-1, 0.0, -1)
    return -1, 0.0, -1


def find_contact(path: np.ndarray, local_map: LocalMap) -> ContactPoint | None:
    """p_c of a reference (n, 2), or None where it stays in F or leaves it through a frontier."""
    index, share, k = _first_exit(local_map.border, local_map.surface, local_map.shadow, path - local_map.position)
    if index < 0:
        return None
    step = path[index] - path[index - 1]
    return ContactPoint(
        index=index,
        share=share,
        point=path[index - 1] + share * step,
        direction=step / max(float(np.hypot(*step)), 1e-12),
        normal=local_map.normals[k],
        surface=int(local_map.surface[k]),
    )


def incidence(contact: ContactPoint) -> float:
    """Angle between the reference and the boundary at the contact, 0 along it, pi/2 square on [rad]."""
    return math.asin(min(1.0, abs(float(contact.direction @ contact.normal))))


def by_incidence(path: np.ndarray, contact: ContactPoint, threshold: float) -> str:
    """The maneuver by angle: contacts flatter than the threshold [rad] follow the boundary, others flow through."""
    return BOUNDARY_FOLLOWING if incidence(contact) < threshold else FLOW_THROUGH


def by_side_of_chord(path: np.ndarray, contact: ContactPoint, threshold: float) -> str:
    """The maneuver as printed: by the side of the chord WP_1 WP_4 on which p_c lies, so that mirrored worlds differ."""
    chord, to_contact = path[-1] - path[0], contact.point - path[0]
    left = np.array([-chord[1], chord[0]])
    return FLOW_THROUGH if float(left @ to_contact) >= 0.0 else BOUNDARY_FOLLOWING


MANEUVER_RULES = {"incidence": by_incidence, "printed": by_side_of_chord}
"""Alg. 3 for a contact, by controller.maneuver_rule."""


def select_maneuver(path: np.ndarray, contact: ContactPoint | None, control: Control) -> str:
    """Alg. 3 for a reference (n, 2): free_space without a contact, else boundary_following or flow_through."""
    if contact is None:
        return FREE_SPACE
    return MANEUVER_RULES[control.maneuver_rule](path, contact, control.incidence_threshold)
