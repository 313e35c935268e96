"""The worlds of the bench with movers: one to three movers near the shortest way, whoever drives there.

Nobody comes back for ever over a robot that gives way: who walks to and fro does so for WALKS, then stays, and all that
stay leave a way to the goal.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from collplan_core.worlds import Mover, World, WorldError, load_world
from collplan_core.worlds.movers import DISC, HIP, KINDS, PERSON, place_at
from collplan_core.worlds.route import free_space
from omnipuck_sim.robot.walks import within_walls

FAMILIES = ("random", "baffles", "floor")
SPEEDS, RADII = (0.3, 1.2), {DISC: (0.08, 0.13), PERSON: (0.05, 0.07)}
"""[m/s], and of a disc and of each leg of a person [m]."""
SPACING, ROOM = 0.05, 0.12
"""Spacing of the places that the shortest way leads over, and what it keeps from obstacles [m]."""
PACE = 0.8
"""Speed at which a robot is expected along the way; movers set out so that they meet it [m/s]."""
WALKS = 6.0
"""Most time for which it walks to and fro [s], unless one round takes longer."""
OFTEN = 0.5
"""Share of the time in which there must be a way to the goal between the movers."""
AT_LAST = 1000.0
"""A time when all movers stay [s]: there must be one then."""
PASSING, STAYING = (0.10, 0.10), (ROOM, 0.15)
"""Distances of a way from obstacles and from movers, while these walk and when they stay [m]."""
BESIDE = 0.1
"""Distance from start and goal that counts as there [m]."""
ASIDE = 0.45
"""Distance from the robot's start within which no mover begins [m]."""
NEIGHBOURS = ((1, 0), (0, 1), (1, 1), (1, -1))


class Scene(NamedTuple):
    """Surroundings that a mover is drawn for: world, shortest way (n, 2) [m], what it is, its speed, random numbers."""

    world: World
    way: np.ndarray
    kind: str
    radius: float
    speed: float
    random: np.random.Generator

    def at(self, share: float) -> tuple[np.ndarray, np.ndarray]:
        """A place of the way [m] and the direction there."""
        k = round(share * (len(self.way) - 1))
        along = self.way[min(k + 3, len(self.way) - 1)] - self.way[max(k - 3, 0)]
        return self.way[k], along / np.hypot(*along)

    def reach(self, place: np.ndarray, direction: np.ndarray, most: float) -> np.ndarray:
        """The farthest place that the mover can walk to from a place in a direction [m]."""
        corners = self.world.bounds[:2], self.world.bounds[2:]
        leg = shapely.LineString([place, np.clip(place + most * direction, *corners)])
        free = leg.intersection(free_space(self.world, self.radius + HIP * (self.kind == PERSON)))
        if free.is_empty:
            raise WorldError("no room")
        first = min(shapely.get_parts(free), key=shapely.Point(place).distance)
        return max(np.array(first.coords), key=lambda point: float(np.hypot(*(point - place))))


def crossing(scene: Scene, most: float = 0.9) -> tuple[list[np.ndarray], float]:
    """Way points, and the share of the shortest way at which it meets the robot."""
    share = scene.random.uniform(0.3, 0.8)
    place, along = scene.at(share)
    aside = scene.random.choice([-1.0, 1.0]) * np.array([-along[1], along[0]])
    return [scene.reach(place, -aside, most), place, scene.reach(place, aside, most)], share


def turning(scene: Scene) -> tuple[list[np.ndarray], float]:
    return crossing(scene, 0.3)


def towards(scene: Scene) -> tuple[list[np.ndarray], float]:
    begins = scene.random.uniform(0.6, 0.95)
    return [scene.at(share)[0] for share in np.arange(begins, 0.2, -0.08)], 0.5 * begins


def beside(scene: Scene) -> tuple[list[np.ndarray], float]:
    share = scene.random.uniform(0.15, 0.4)
    place, along = scene.at(share)
    aside = scene.random.choice([-1.0, 1.0]) * scene.random.uniform(0.25, 0.35) * np.array([-along[1], along[0]])
    return [place + aside, scene.reach(place + aside, along, 1.5)], share


def emerging(scene: Scene) -> tuple[list[np.ndarray], float]:
    """Begins where a wall hides it from the robot that comes."""
    share = scene.random.uniform(0.3, 0.85)
    place, _ = scene.at(share)
    view = scene.at(max(share - 0.25, 0.0))[0]
    angle = scene.random.uniform(-np.pi, np.pi)
    hidden = scene.reach(place, np.array([np.cos(angle), np.sin(angle)]), 0.9)
    solids = [shapely.Polygon(corners) for corners in scene.world.polygons]
    if not shapely.intersects(shapely.union_all(solids), shapely.LineString([view, hidden])):
        raise WorldError("in view")
    return [hidden, scene.reach(place, place - hidden, 1.0)], share


WAYS: dict[str, Callable[[Scene], tuple[list[np.ndarray], float]]] = {
    "crossing": crossing, "stopping": crossing, "turning": turning,
    "towards": towards, "beside": beside, "emerging": emerging,
}  # fmt: skip
OPEN = tuple(way for way in WAYS if way != "emerging")


def world_of(index: int, seed: int) -> World:
    """The world of a trial, without movers."""
    family = FAMILIES[index % len(FAMILIES)]
    if family != "floor":
        return load_world(f"{family}:{seed + index}")
    random = np.random.default_rng([seed, index, 1])
    start, goal = (np.array([x, random.uniform(0.3, 1.7)]) for x in (0.3, 2.1))
    return replace(load_world(family), start=start, goal=goal)


def with_movers(world: World, index: int, seed: int) -> World:
    """The world with its movers."""
    random, way = np.random.default_rng([seed, index, 2]), shortest_way(world)
    while True:
        moved = replace(world, movers=tuple(_movers(world, way, random)))
        if _is_passable(moved):
            return moved


def _movers(world: World, way: np.ndarray, random: np.random.Generator) -> Iterator[Mover]:
    left = int(random.integers(1, 4))
    while left:
        walks, kind = str(random.choice(list(WAYS) if world.polygons else OPEN)), str(random.choice(KINDS))
        try:
            yield _drawn(walks, Scene(world, way, kind, random.uniform(*RADII[kind]), random.uniform(*SPEEDS), random))
        except ValueError:
            continue  # no room for it there
        left -= 1


def _is_passable(world: World) -> bool:
    """No gap is closed for most of the time, or for ever: nobody could arrive then."""
    assert world.start is not None
    assert world.goal is not None
    times = np.arange(1.0, 30.0, 1.7)
    open_at = sum(_is_open(world, time, PASSING) for time in times)
    return open_at >= OFTEN * len(times) and _is_open(world, AT_LAST, STAYING)


def _is_open(world: World, time: float, room: tuple[float, float]) -> bool:
    """Returns whether a way leads to the goal, with this `room` to obstacles and to the movers of that time [m]."""
    discs = [shapely.Point(place_at(mover, time)).buffer(mover.reach + room[1]) for mover in world.movers]
    parts = shapely.get_parts(free_space(world, room[0]).difference(shapely.union_all(discs)))
    ends = shapely.points([world.start, world.goal])
    return any(shapely.distance(part, ends).max() < BESIDE for part in parts)


def _drawn(walks: str, scene: Scene) -> Mover:
    """Raises ValueError where it has no room, or begins at the robot."""
    points, share = WAYS[walks](scene)
    random = scene.random
    meets = share * SPACING * len(scene.way) / PACE + random.uniform(-0.5, 0.5)
    delay = max(0.0, meets - float(np.hypot(*(scene.at(share)[0] - points[0]))) / scene.speed)
    pause = random.uniform(0.5, 1.5) if walks == "stopping" else 0.0
    again = bool(random.random() < 0.7)
    mover = Mover(scene.radius, np.array(points), scene.speed, again, delay, pause, kind=scene.kind)
    mover = within_walls(replace(scene.world, movers=(mover,)), 0)
    short = np.hypot(*np.diff(mover.way, axis=0).T).sum() < 0.2
    if short or np.hypot(*(mover.way[0] - scene.way[0])) < ASIDE:
        raise WorldError("no room")
    return replace(mover, rounds=max(1, int(WALKS / mover.schedule[0][-1])))


def shortest_way(world: World) -> np.ndarray:
    """(n, 2) places about SPACING apart from start to goal [m]."""
    free = free_space(world, ROOM)
    x0, y0, x1, y1 = world.bounds
    columns, rows = round((x1 - x0) / SPACING), round((y1 - y0) / SPACING)
    places = np.array([(x0 + SPACING * i, y0 + SPACING * j) for i in range(columns + 1) for j in range(rows + 1)])
    is_free = shapely.contains_xy(free, places)
    numbers = np.arange(len(places)).reshape(columns + 1, rows + 1)
    pairs = []
    for i, j in NEIGHBOURS:
        a = numbers[: columns + 1 - i, max(-j, 0) : rows + 1 - max(j, 0)].ravel()
        pairs.append(np.column_stack([a, a + i * (rows + 1) + j]))
    edges = np.vstack(pairs)
    edges = edges[is_free[edges].all(axis=1)]
    lengths = np.hypot(*(places[edges[:, 0]] - places[edges[:, 1]]).T)
    graph = csr_matrix((lengths, edges.T), shape=(len(places), len(places)))
    begin, end = (_nearest(places, is_free, point) for point in (world.start, world.goal))
    _, before = dijkstra(graph, directed=False, indices=begin, return_predecessors=True)
    way = [end]
    while way[-1] != begin:
        way.append(int(before[way[-1]]))
        if way[-1] < 0:
            raise WorldError(f"{world.called}: no way with {ROOM} m of room")
    return places[way[::-1]]


def _nearest(places: np.ndarray, is_free: np.ndarray, point: np.ndarray | None) -> int:
    return int(np.argmin(np.where(is_free, np.hypot(*(places - point).T), np.inf)))
