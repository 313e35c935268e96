"""The maneuver for a path that leaves F through an observed boundary. Paper: III-B, Alg. 3."""

import math

import numpy as np

from collplan_core.command import BOUNDARY_FOLLOWING, FLOW_THROUGH, FREE_SPACE
from collplan_core.local_map.contact_point import ContactPoint
from collplan_core.parameters import Control


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
