"""Clearance fields of straight walls, exact at their nodes, and the shortest paths between such walls."""

import numpy as np
import shapely
from scipy.sparse.csgraph import dijkstra

from collplan_core.parameters import Settings
from collplan_core.time_to_goal_planner.boundary_memory.clearance import FAR, NOTHING, OBSERVED, ClearanceField
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import heading, time_to_go
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths

SETTINGS = Settings()
ROBOT, TOLERANCE = SETTINGS.robot, SETTINGS.planner.goal_tolerance
SPEED, ACCELERATION = ROBOT.max_speed, ROBOT.max_acceleration


def walls(*corners) -> np.ndarray:
    """(n, 4) segments of a polyline."""
    points = np.array(corners, dtype=float)
    return np.hstack([points[:-1], points[1:]])


def turned(segments: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    return (segments.reshape(-1, 2) @ matrix.T).reshape(-1, 4)


def field_of(segments: np.ndarray, center=(0.0, 0.0), half_side=1.6, spacing=0.02) -> ClearanceField:
    """The field around segments (n, 4); a node lies at the center."""
    reach = int(np.ceil(half_side / spacing))
    steps = spacing * np.arange(-reach, reach + 1)
    nodes = np.stack(np.meshgrid(steps + center[0], steps + center[1], indexing="ij"), axis=-1)
    distance = np.full(nodes.shape[:2], np.inf)
    for a, b in np.asarray(segments, dtype=float).reshape(-1, 2, 2):
        share = np.clip((nodes - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        distance = np.minimum(distance, np.linalg.norm(nodes - a - share[..., None] * (b - a), axis=-1))
    clearance = np.minimum(distance - ROBOT.radius, FAR)
    source = np.where(clearance < FAR, OBSERVED, NOTHING).astype(np.int8)
    return ClearanceField(np.array([steps[0] + center[0], steps[0] + center[1]]), spacing, clearance, source)


def exact_lengths(
    segments: np.ndarray, goal: np.ndarray, positions: np.ndarray, radius: float = ROBOT.radius
) -> np.ndarray:
    """Lengths of a disc's shortest paths from positions (n, 2) to the goal, over the corners of the grown walls."""
    lines = shapely.multilinestrings(segments.reshape(-1, 2, 2))
    corners = shapely.get_coordinates(lines.buffer(radius, quad_segs=16))
    points = np.vstack([goal, positions, corners])
    i, j = np.triu_indices(len(points), 1)
    solid = lines.buffer(radius - 1e-4, quad_segs=16)
    shapely.prepare(solid)
    free = ~shapely.intersects(solid, shapely.linestrings(np.stack([points[i], points[j]], axis=1)))
    lengths = np.zeros((len(points), len(points)))
    lengths[i[free], j[free]] = np.linalg.norm(points[i[free]] - points[j[free]], axis=1)
    return dijkstra(lengths, directed=False, indices=0)[1 : 1 + len(positions)]


def to_go(paths: ShortestPaths, position, velocity=(0.0, 0.0)) -> float:
    return time_to_go(
        paths.waypoint, paths.waypoints, paths.onward, paths.remaining, paths.turning, *map(float, paths.origin),
        paths.spacing, *map(float, paths.goal), paths.tolerance, SPEED, ACCELERATION, *map(float, position),
        *map(float, velocity),
    )  # fmt: skip


def toward(paths: ShortestPaths, position) -> tuple[float, float, float]:
    return heading(
        paths.waypoint, paths.waypoints, paths.onward, paths.remaining, *map(float, paths.origin), paths.spacing,
        *map(float, position),
    )  # fmt: skip


def path_length(paths: ShortestPaths, place) -> float:
    """Length from a place, by the way point of the cell nearest to it [m]."""
    cell = np.round((np.asarray(place) - paths.origin) / paths.spacing).astype(int)
    number = paths.waypoint[tuple(np.clip(cell, 0, np.array(paths.waypoint.shape) - 1))]
    return float(np.hypot(*(paths.waypoints[number] - place)) + paths.remaining[number]) if number >= 0 else np.inf
