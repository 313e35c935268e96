"""The movers of a world step by step: they walk, and meet its walls and the robot.

A wall that the way leads through is its end: a mover that walks to and fro turns back there, another one stays.

A mover that comes up against the robot strikes it with its whole velocity, for as long as a hit may last. Then it
stands for as long as the robot is in its way, which is ahead of it and nearer than CLEARED. After PATIENCE one that
walks to and fro turns back. A robot that touches a mover from behind or aside does not stop it. A mover weighs so much
more than the robot that no hit changes its motion. Movers walk through each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import hypot
from typing import NamedTuple

import numpy as np
import shapely

from collplan_core.parameters import Settings
from collplan_core.worlds import Mover, World, WorldError
from collplan_core.worlds.gait import Gait, discs_at, gait_of
from collplan_core.worlds.movers import PERSON, turned
from collplan_core.worlds.route import free_space
from omnipuck_sim.robot.drive import VX, VY, X, Y

CLEARED = 0.05
"""Distance between a mover and the robot from which the robot is no longer in its way [m]."""
PATIENCE = 1.0
"""Time for which it stands before the robot [s]."""
APART = 0.002
"""Distance between both from which a touch has ended [m]."""
NO_MOVERS = np.zeros((0, 5))


class Touch(NamedTuple):
    """A touch of robot and mover that has begun."""

    time: float  # of its begin [s]
    mover: int  # number of its disc among `Walks.discs`
    speed: float  # the robot's own towards the mover just before, negative away from it [m/s]


@dataclass(eq=False)
class _Walk:
    """One mover: its time, which stands still when it does, since when it meets the robot, and which discs touch it."""

    gait: Gait
    rows: range
    time: float = 0.0
    met: float | None = None
    touching: set[int] = field(default_factory=set)


class Walks:
    """All movers of a world, step by step.

    `discs` (k, 5) are x, y [m], vx, vy [m/s], radius [m] of each disc, two of a person; in a step its place before, its
    velocity during it.
    """

    def __init__(self, world: World, settings: Settings) -> None:
        """Raises WorldError where a mover begins in an obstacle."""
        self._radius, self._step = settings.robot.radius, 1.0 / settings.simulator.physics_rate
        self._strike = settings.simulator.contact_time
        self._walks: list[_Walk] = []
        rows: list[tuple[float, ...]] = []
        for i in range(len(world.movers)):
            gait = gait_of(within_walls(world, i))
            discs = discs_at(gait, 0.0)
            self._walks.append(_Walk(gait, range(len(rows), len(rows) + len(discs))))
            rows += [(*place, 0.0, 0.0, gait.mover.radius) for place in discs]
        self.discs = np.array(rows).reshape(-1, 5)
        self.touches: list[Touch] = []  # so far; may be emptied

    def begin(self, time: float, motion: Sequence[float]) -> None:
        """Chooses the velocities of the step that begins at `time` [s], in which the robot has this motion (8,)."""
        for walk in self._walks:
            mover, step = walk.gait.mover, self._step
            discs, after = discs_at(walk.gait, walk.time), discs_at(walk.gait, walk.time + step)
            moves = [((x1 - x0) / step, (y1 - y0) / step) for (x0, y0), (x1, y1) in zip(discs, after, strict=True)]
            aparts = [(motion[X] - x, motion[Y] - y) for x, y in discs]
            gaps = [
                hypot(x + step * (motion[VX] - vx), y + step * (motion[VY] - vy)) - (self._radius + mover.radius)
                for (x, y), (vx, vy) in zip(aparts, moves, strict=True)
            ]
            (vx, vy), (apart_x, apart_y) = _mean(moves), _mean(aparts)
            gap, ahead = min(gaps), vx * apart_x + vy * apart_y > 0.0
            if walk.met is None and ahead and gap <= 0.0:
                walk.met = time
            elif walk.met is not None and not (ahead and gap < CLEARED):
                walk.met = None
            waits = 0.0 if walk.met is None else time - walk.met
            if gap <= 0.0 and mover.kind == PERSON:
                # a foot that meets something is put down: the person strikes, not the swing of the leg
                moves = [(vx, vy)] * len(moves)
            if waits > self._strike:
                moves = [(0.0, 0.0)] * len(moves)
                if waits > PATIENCE and mover.to_and_fro:
                    walk.time, walk.met = turned(mover, walk.time), None
            else:
                walk.time += step
            for row, place, moved, apart, beside in zip(walk.rows, discs, moves, aparts, gaps, strict=True):
                self.discs[row, :4] = *place, *moved
                if beside <= 0.0 and row not in walk.touching:
                    towards = motion[VX] * apart[0] + motion[VY] * apart[1]
                    self.touches.append(Touch(time, row, -towards / max(hypot(*apart), 1e-9)))
                if beside <= (APART if row in walk.touching else 0.0):
                    walk.touching.add(row)
                else:
                    walk.touching.discard(row)

    def end(self) -> None:
        """Ends the step."""
        self.discs[:, :2] += self._step * self.discs[:, 2:4]


def _mean(pairs: Sequence[tuple[float, float]]) -> tuple[float, float]:
    return sum(x for x, _ in pairs) / len(pairs), sum(y for _, y in pairs) / len(pairs)


def within_walls(world: World, number: int) -> Mover:
    """A mover, its way cut off at an obstacle or wall; WorldError: it has no room at its first way point."""
    mover = world.movers[number]
    free, way = free_space(world, mover.reach), [mover.way[0]]
    if not free.covers(shapely.Point(way[0])):
        key = f"{world.called}: movers[{number}].way[0]: {way[0].tolist()}"
        raise WorldError(f"{key} is too near an obstacle, expected {mover.reach:g} m of room around it")
    for a, b in pairwise(mover.way):
        parts = shapely.get_parts(shapely.LineString([a, b]).intersection(free))
        first = min(parts, key=shapely.Point(a).distance, default=None)
        reached = max((np.hypot(*(np.array(point) - a)) for point in first.coords), default=0.0) if first else 0.0
        whole = float(np.hypot(*(b - a)))
        if reached > whole - 1e-9:
            way.append(b)
            continue
        if reached > 1e-6:
            way.append(a + (reached - 1e-6) / whole * (b - a))
        break
    times = mover.times
    if times is not None and len(way) < len(times):
        times = times[: len(way)]
    return replace(mover, way=np.array(way), times=times)
