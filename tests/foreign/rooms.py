"""Three rooms for ir-sim, with a start and goals in them."""

from dataclasses import dataclass
from pathlib import Path

import yaml

RADIUS = 0.15
LIDAR_AT = (0.06, -0.03, 0.5)
"""The LIDAR on the robot: forward, to the left [m], heading [rad]."""


@dataclass(frozen=True)
class Room:
    """Size x, y, start x, y, goals x, y [m]; walls: x, y of the middle, length along x, width along y [m]."""

    size: tuple[float, float]
    start: tuple[float, float]
    goals: tuple[tuple[float, float], ...]
    walls: tuple[tuple[float, float, float, float], ...]


POSTS = ((1.4, 1.6, 0.2, 0.2), (2.6, 1.2, 0.2, 0.2), (2.2, 2.7, 0.2, 0.2))
ROOMS = {
    "hall": Room((5.0, 4.0), (0.7, 0.7), ((4.3, 3.3), (0.7, 3.3), (4.3, 0.7)), ((2.5, 2.0, 1.2, 0.1),)),
    "door": Room((4.0, 3.0), (0.6, 1.5), ((3.4, 1.5), (3.4, 0.6)), ((2.0, 0.55, 0.1, 1.1), (2.0, 2.45, 0.1, 1.1))),
    "posts": Room((4.0, 4.0), (0.5, 0.5), ((3.5, 3.5), (3.5, 0.5)), POSTS),
}


def write_world(room: Room, path: Path) -> Path:
    """Writes the room as ir-sim reads it; the border is four more walls."""
    x, y = room.size
    border = ((x / 2, -0.05, x, 0.1), (x / 2, y + 0.05, x, 0.1), (-0.05, y / 2, 0.1, y), (x + 0.05, y / 2, 0.1, y))
    walls = [
        {"shape": {"name": "rectangle", "length": length, "width": width}, "state": [at_x, at_y, 0.0]}
        for at_x, at_y, length, width in (*room.walls, *border)
    ]
    lidar = {"name": "lidar2d", "range_min": 0.05, "range_max": 6.0, "angle_range": 6.2832, "number": 240}
    lidar["offset"] = [*LIDAR_AT]
    robot = {
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": RADIUS},
        "state": [*room.start, 0.0],
        "goal": [*room.goals[0], 0.0],
        "vel_max": [2.0, 2.0],
        "sensors": [lidar],
    }
    world = {"width": x, "height": y, "step_time": 0.02, "collision_mode": "unobstructed"}
    path.write_text(yaml.safe_dump({"world": world, "robot": [robot], "obstacle": walls}))
    return path
