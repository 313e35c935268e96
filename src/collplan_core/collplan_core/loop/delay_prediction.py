"""Motion under way when a plan is made: earlier commands act until the plan's first command does.

A command sent at t, on the poses' clock, moves the wheels at t plus the delay from a pose's stamp to the wheels: that
of motion capture, transport and firmware, the lag of the velocity law apart.
"""

from dataclasses import dataclass, replace

import numpy as np

from collplan_core.local_map.contact_point import find_contact
from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Settings
from collplan_core.plan import Contacts, Plan
from collplan_core.reflection import believed_ring, rebound
from collplan_core.state import State
from collplan_core.velocity_law import rolled, velocity_law

STEP = 0.005
"""Spacing of the samples, and of the delays distinguished [s]."""


@dataclass(frozen=True, eq=False)
class UnderWay:
    """Motion of the robot until a plan acts, world frame."""

    times: np.ndarray  # (n,) STEP apart from the stamp of the pose on [s]
    positions: np.ndarray  # (n, 2) then [m]
    velocities: np.ndarray  # (n, 2) then [m/s]
    contacts: Contacts  # contacts during it
    yaw: float  # yaw of the pose [rad]

    @property
    def end(self) -> State:
        """State of the robot when the plan takes effect."""
        return State(float(self.times[-1]), self.positions[-1].copy(), self.velocities[-1].copy(), self.yaw)

    def before(self, plan: Plan) -> Plan:
        """A plan made from the end, with this motion before it; its stamp is that of the pose."""
        own, known = self.contacts, plan.contacts
        parts = ("times", "points", "velocities_after", "normals", "speeds")
        return replace(
            plan,
            stamp=float(self.times[0]),
            times=np.concatenate([self.times[:-1], plan.times]),
            positions=np.concatenate([self.positions[:-1], plan.positions]),
            velocities=None if plan.velocities is None else np.concatenate([self.velocities[:-1], plan.velocities]),
            contacts=Contacts(*(np.concatenate([getattr(own, part), getattr(known, part)]) for part in parts)),
        )


def motion_under_way(
    state: State, commands: np.ndarray, delay: float, ahead: float, local_map: LocalMap, settings: Settings
) -> UnderWay:
    """The motion from a pose on for a time `ahead` [s], by the velocity law, with rebounds from the boundaries seen.

    Commands (n, 3): when each was sent [s, poses' clock], and its velocity [m/s, world frame]; rest before these. Each
    acts `delay` [s] later.
    """
    n = round(ahead / STEP)
    times = state.stamp + STEP * np.arange(n + 1)
    newest = np.searchsorted(commands[:, 0], times[:-1] - delay + 1e-6, side="right")
    wanted = np.vstack([np.zeros((1, 2)), commands[:, 1:]])[newest]
    wheels, ring, steps = velocity_law(settings.robot, STEP), believed_ring(settings), np.full(n, STEP)
    motion, first, found = np.hstack([state.position, state.velocity]), 0, []
    rows = rolled(wheels, motion, wanted, steps)
    while (contact := find_contact(rows[first:, :2], local_map)) is not None:
        i = first + contact.index
        into = rows[i - 1, 2:] + contact.share * (rows[i, 2:] - rows[i - 1, 2:])
        if into @ contact.normal >= 0.0:
            # noise has put the pose beyond a boundary that the robot leaves
            break
        after = rebound(into, contact.normal, ring)
        point = contact.point - settings.robot.radius * contact.normal
        found.append((times[i - 1] + contact.share * STEP, point, after, contact.normal, -float(into @ contact.normal)))
        rows[i] = np.hstack([contact.point + (1.0 - contact.share) * STEP * after, after])
        rows[i:] = rolled(wheels, rows[i], wanted[i:], steps[i:])
        first = i
        if not local_map.contains(rows[i, :2])[0]:
            break
    columns = [np.array(each) for each in zip(*found, strict=True)] if found else []
    contacts = Contacts(*columns) if found else Contacts.none()
    return UnderWay(times, rows[:, :2].copy(), rows[:, 2:].copy(), contacts, state.yaw)
