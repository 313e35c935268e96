"""Contacts that a plan foresees: at an observed boundary on its way, or at a predicted one behind its end."""

import math

import numpy as np

from collplan_core.local_map.contact_point import find_contact
from collplan_core.local_map.record import LocalMap
from collplan_core.paper_planner.costs.model import REBOUND_HORIZON
from collplan_core.paper_planner.costs.risk import contact_distance
from collplan_core.parameters import Settings
from collplan_core.plan import Contacts
from collplan_core.reflection import believed_ring, rebound


def foreseen_contacts(
    local_map: LocalMap, times: np.ndarray, positions: np.ndarray, velocities: np.ndarray, settings: Settings
) -> Contacts:
    """The first contact of a reference: times (n,), positions (n, 2), velocities (n, 2), world frame.

    A predicted boundary counts where it is met within REBOUND_HORIZON after the end at the end's velocity. The robot's
    own radius separates the disc's centre from the point touched.
    """
    contact = find_contact(positions, local_map)
    if contact is not None:
        i, share = contact.index, contact.share
        time = times[i - 1] + share * (times[i] - times[i - 1])
        velocity = velocities[i - 1] + share * (velocities[i] - velocities[i - 1])
        return _contact(time, contact.point, velocity, contact.normal, settings)
    (x, y), (vx, vy) = positions[-1].tolist(), velocities[-1].tolist()
    speed = math.hypot(vx, vy)
    if speed < 1e-9:
        return Contacts.none()
    distance, line = contact_distance(x, y, vx / speed, vy / speed, local_map.predicted)
    if line < 0 or distance / speed > REBOUND_HORIZON:
        return Contacts.none()
    tangent = local_map.predicted[line, 2:]
    normal = np.array([-tangent[1], tangent[0]])
    normal = normal if normal @ velocities[-1] < 0.0 else -normal
    center = positions[-1] + velocities[-1] / speed * distance
    return _contact(times[-1] + distance / speed, center, velocities[-1], normal, settings)


def _contact(time: float, center: np.ndarray, velocity: np.ndarray, normal: np.ndarray, settings: Settings) -> Contacts:
    """The contact at a time [s] of a disc with center (2,) [m] and velocity (2,) [m/s], and the rebound from it."""
    after = rebound(velocity, normal, believed_ring(settings))
    point, speed = center - settings.robot.radius * normal, -float(velocity @ normal)
    return Contacts(np.array([time]), point[None], after[None], normal[None], np.array([max(speed, 0.0)]))
