"""Clearance fields of walls, faces and pillars, exact at their nodes; shortest paths and full plans over them."""

from dataclasses import replace

import numpy as np
import shapely
from scipy.sparse.csgraph import dijkstra

from collplan_core.parameters import Settings
from collplan_core.time_to_goal_planner.boundary_memory.clearance import FAR, NOTHING, OBSERVED, ClearanceField
from collplan_core.time_to_goal_planner.dynamics import Contact, Motion, course_of, motion_at, step
from collplan_core.time_to_goal_planner.full_plan import FullPlan, roll
from collplan_core.time_to_goal_planner.initial_plans import padded
from collplan_core.time_to_goal_planner.model import Problem, contact_costs, problem_of, robot_model
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import path_direction, time_to_go
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths
from collplan_core.velocity_bounds import velocity_bounds

SETTINGS = Settings()
ROBOT, TOLERANCE = SETTINGS.robot, SETTINGS.planner.goal_tolerance
RADIUS, SPEED, ACCELERATION = ROBOT.radius, ROBOT.max_speed, ROBOT.max_acceleration
BOUNDS = velocity_bounds(ROBOT)
SPACING = SETTINGS.remembered.spacing


def with_strategy(strategy: str, **values) -> Settings:
    """Settings of a strategy; group__field=value sets more."""
    return SETTINGS.with_values(
        {"planner.strategy": strategy, **{key.replace("__", "."): value for key, value in values.items()}}
    )


def nodes_around(center=(0.0, 0.0), half_side: float = 1.6) -> np.ndarray:
    """Places (n, n, 2) of nodes; one lies at the center."""
    reach = int(np.ceil(half_side / SPACING))
    steps = SPACING * np.arange(-reach, reach + 1)
    return np.stack(np.meshgrid(steps + center[0], steps + center[1], indexing="ij"), axis=-1)


def field_from(clearance: np.ndarray, places: np.ndarray, source: int = OBSERVED) -> ClearanceField:
    clearance = np.minimum(clearance, FAR)
    sources = np.where(clearance < FAR, source, NOTHING).astype(np.int8)
    return ClearanceField(places[0, 0], SPACING, clearance, sources)


def open_field(**nodes) -> ClearanceField:
    places = nodes_around(**nodes)
    return field_from(np.full(places.shape[:2], np.inf), places)


def faces_field(*faces, source: int = OBSERVED, **nodes) -> ClearanceField:
    """Flat faces that the disc's centre keeps behind: (bearing out of the wall [rad], distance from (0, 0) [m])."""
    places = nodes_around(**nodes)
    normals = np.array([[np.cos(bearing), np.sin(bearing)] for bearing, _ in faces])
    depths = places @ normals.T + np.array([distance for _, distance in faces])
    return field_from(depths.min(axis=-1), places, source)


def pillars_field(*pillars, **nodes) -> ClearanceField:
    places = nodes_around(**nodes)
    distances = [np.hypot(places[..., 0] - x, places[..., 1] - y) - radius - RADIUS for x, y, radius in pillars]
    return field_from(np.min(distances, axis=0), places)


def walls_field(segments: np.ndarray, **nodes) -> ClearanceField:
    places = nodes_around(**nodes)
    distance = np.full(places.shape[:2], np.inf)
    for a, b in np.asarray(segments, dtype=float).reshape(-1, 2, 2):
        share = np.clip((places - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        distance = np.minimum(distance, np.linalg.norm(places - a - share[..., None] * (b - a), axis=-1))
    return field_from(distance - RADIUS, places)


def joined(*fields: ClearanceField) -> ClearanceField:
    which = np.argmin([field.clearance for field in fields], axis=0)
    clearance = np.min([field.clearance for field in fields], axis=0)
    return replace(fields[0], clearance=clearance, source=np.choose(which, [field.source for field in fields]))


def walls(*corners) -> np.ndarray:
    points = np.array(corners, dtype=float)
    return np.hstack([points[:-1], points[1:]])


def exact_lengths(segments: np.ndarray, goal: np.ndarray, positions: np.ndarray, radius: float = RADIUS) -> np.ndarray:
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
    lookup = paths.lookup(paths.tolerance)
    return time_to_go(lookup, BOUNDS, ACCELERATION, *map(float, position), *map(float, velocity))


def toward(paths: ShortestPaths, position) -> tuple[float, float, float]:
    return path_direction(paths.lookup(paths.tolerance), *map(float, position))


def path_length(paths: ShortestPaths, place) -> float:
    cell = np.round((np.asarray(place) - paths.origin) / paths.spacing).astype(int)
    number = paths.waypoint[tuple(np.clip(cell, 0, np.array(paths.waypoint.shape) - 1))]
    return float(np.hypot(*(paths.waypoints[number] - place)) + paths.remaining[number]) if number >= 0 else np.inf


def problem_over(field: ClearanceField, goal=(1.2, 0.0), strategy: str = "bounce", free=None) -> Problem:
    """The problem over a field, without a stop test; free wherever the disc fits, if nothing else is said."""
    goal, settings = np.array(goal, dtype=float), with_strategy(strategy)
    free = field.clearance >= 0.0 if free is None else free
    return problem_of(field, free, shortest_paths(field, goal, goal, settings), settings)._replace(stop_test=False)


def of_strategy(problem: Problem, strategy: str, stop_test: bool = False) -> Problem:
    settings = with_strategy(strategy)
    constants = problem.constants._replace(model=robot_model(settings), costs=contact_costs(settings))
    return problem._replace(constants=constants, stop_test=stop_test)


def motion_in(problem: Problem, state, steps: int = 0) -> Motion:
    """The motion of a state (x, y, vx, vy), so many steps after a plan began."""
    return motion_at(problem.clearance, problem.constants.grid, *map(float, state), steps)


def rolled(problem: Problem, state, commands, most: int = 0) -> FullPlan:
    """Commands (n, 2) from a state (x, y, vx, vy); room for `most` control intervals where that is more than n."""
    commands = np.array(commands, dtype=float).reshape(-1, 2)
    return roll(problem, motion_in(problem, state), padded(commands, max(most, len(commands))), len(commands))


def has_arrived(problem: Problem, plan: FullPlan) -> bool:
    goal = problem.constants.goal
    return bool(np.hypot(plan.states[plan.n, 0] - goal.x, plan.states[plan.n, 1] - goal.y) <= goal.tolerance)


def stepped(problem: Problem, state, commands, begun: int = 0) -> list[tuple[Motion, Contact]]:
    """What `step` makes of a state step by step under commands (n, 2), one a step, `begun` steps after a plan began."""
    motion, steps = motion_in(problem, state, begun), []
    for ux, uy in np.asarray(commands, dtype=float):
        grid, _, model, _, _ = problem.constants
        course = course_of(motion, ux, uy)
        motion, _, contact = step(problem.clearance, problem.source, grid, model, motion, course)
        steps.append((motion, contact))
    return steps
