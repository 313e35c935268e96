"""The families `random`, convex clutter, and `posts`, round posts: strewn over a square, from corner to corner."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.worlds.placement import BODY_WIDTH, DISC_RADIUS, SIDE, Draw, draws_of, rounded
from collplan_core.worlds.route import check_route
from collplan_core.worlds.shapes import World, WorldError

START_MARGIN = 0.25
START_AREA = 0.35
ROOM = 0.16
N_TRIES = 400


class Clutter(NamedTuple):
    """Properties of random clutter."""

    n_obstacles: tuple[int, int]
    """Least number of obstacles, and one more than the greatest; fewer where they do not fit."""
    size: tuple[float, float]  # least and greatest distance of a polygon's corners from its middle [m]
    circle_share: float  # share of circles among them
    circle_size: float  # radius of one, by its size
    gap: float  # least width of a gap between two obstacles, or between an obstacle and a wall [m]
    disc_radius: float  # start and goal are connected for this disc [m]


# a disc passes every gap with a centimetre to spare
RANDOM = Clutter((6, 11), (0.10, 0.28), 0.3, 0.75, 2 * DISC_RADIUS + 0.01, DISC_RADIUS)
POSTS = Clutter((20, 41), (0.03, 0.08), 1.0, 1.0, BODY_WIDTH + 0.01, BODY_WIDTH / 2)


def random_clutter(seed: int) -> World:
    """Convex clutter in a walled square: polygons of 3 to 6 corners and circles, start and goal in opposite corners.

    No gap between two obstacles, or between an obstacle and a wall, is narrower than 0.20 m; an obstacle may stand in a
    wall. Start and goal are connected for a disc of radius 0.10 m.
    """
    return _strewn(f"random:{seed}", RANDOM, draws_of(seed))


def round_posts(seed: int) -> World:
    """Round posts of 3 to 8 cm radius in a walled square, so dense that many a gap is hardly wider than the robot.

    No gap is narrower than 0.19 m; a post may stand in a wall. Start and goal lie in opposite corners.
    """
    # the name is part of the seed, or the families would share their draws
    return _strewn(f"posts:{seed}", POSTS, draws_of(*b"posts", seed))


def _strewn(name: str, clutter: Clutter, draw: Draw) -> World:
    while True:
        world = _drawn(name, clutter, draw)
        try:
            check_route(world, world.start, world.goal, clutter.disc_radius)  # type: ignore[arg-type]
        except WorldError:
            continue
        return world


def _drawn(name: str, clutter: Clutter, draw: Draw) -> World:
    start, goal = _opposite_points(draw)
    n_obstacles = math.floor(draw(*clutter.n_obstacles))
    obstacles: list[np.ndarray] = []
    for _ in range(N_TRIES):
        if len(obstacles) == n_obstacles:
            break
        obstacle = _obstacle(clutter, draw)
        if _fits(obstacle, obstacles, (start, goal), clutter.gap):
            obstacles.append(obstacle)
    return World(
        name=name,
        polygons=tuple(o for o in obstacles if o.ndim == 2),
        circles=np.array([o for o in obstacles if o.ndim == 1]).reshape(-1, 3),
        bounds=(0.0, 0.0, SIDE, SIDE),
        start=start,
        goal=goal,
    )


def _opposite_points(draw: Draw) -> tuple[np.ndarray, np.ndarray]:
    """Start in one corner's area, goal in the opposite one's."""
    near, far = ([draw(START_MARGIN, START_MARGIN + START_AREA) for _ in range(2)] for _ in range(2))
    flip = [draw(0.0, 1.0) < 0.5 for _ in range(2)]
    start = [SIDE - v if f else v for v, f in zip(near, flip, strict=True)]
    goal = [v if f else SIDE - v for v, f in zip(far, flip, strict=True)]
    return rounded(start), rounded(goal)


def _obstacle(clutter: Clutter, draw: Draw) -> np.ndarray:
    """A circle (3,) or the corners (k, 2) of a polygon with its corners on a circle, which makes it convex."""
    x, y, size = draw(0.0, SIDE), draw(0.0, SIDE), draw(*clutter.size)
    if draw(0.0, 1.0) < clutter.circle_share:
        return rounded([x, y, clutter.circle_size * size])
    n_corners = math.floor(draw(3.0, 7.0))
    first = draw(0.0, 2 * math.pi)
    # each corner keeps to the middle of its own share of the turn, so no edge is short
    angles = [first + 2 * math.pi * (i + draw(-0.3, 0.3)) / n_corners for i in range(n_corners)]
    return rounded([[x + size * math.cos(a), y + size * math.sin(a)] for a in angles])


def _fits(obstacle: np.ndarray, others: list[np.ndarray], points: tuple[np.ndarray, ...], gap: float) -> bool:
    import shapely

    walls = shapely.box(0.0, 0.0, SIDE, SIDE).exterior
    shape, radius = _core(obstacle)
    if 0.0 < shape.distance(walls) - radius < gap:
        return False
    if any(shape.distance(shapely.Point(point)) - radius < ROOM for point in points):
        return False
    cores = [_core(other) for other in others]
    return all(shape.distance(other) - radius - other_radius >= gap for other, other_radius in cores)


def _core(obstacle: np.ndarray) -> tuple:
    """A shapely geometry and how far the obstacle reaches around it [m]: distances to circles stay exact."""
    import shapely

    if obstacle.ndim == 2:
        return shapely.Polygon(obstacle), 0.0
    return shapely.Point(obstacle[:2]), obstacle[2]
