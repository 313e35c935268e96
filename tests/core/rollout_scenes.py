"""Exact clearance fields of flat walls, corners and pillars, and rollouts over them."""

from dataclasses import dataclass, replace

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.time_to_goal_planner.boundary_memory.clearance import FAR, NOTHING, OBSERVED, ClearanceField
from collplan_core.time_to_goal_planner.dynamics import step
from collplan_core.time_to_goal_planner.full_plan import near_at, roll
from collplan_core.time_to_goal_planner.model import Law, Price, Scene, law_of, price_of, scene_of
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths

SETTINGS = Settings()
RADIUS = SETTINGS.robot.radius
SPACING = SETTINGS.remembered.spacing


def with_strategy(strategy: str, **values) -> Settings:
    """Settings of a strategy; group__field=value sets more."""
    return SETTINGS.with_values(
        {"planner.strategy": strategy, **{key.replace("__", "."): value for key, value in values.items()}}
    )


def nodes_around(center=(0.0, 0.0), half_side: float = 1.6) -> tuple[np.ndarray, np.ndarray]:
    """Origin (2,) and places (n, n, 2) of nodes; one lies at the center."""
    reach = int(np.ceil(half_side / SPACING))
    steps = SPACING * np.arange(-reach, reach + 1)
    places = np.stack(np.meshgrid(steps + center[0], steps + center[1], indexing="ij"), axis=-1)
    return places[0, 0], places


def field_from(clearance: np.ndarray, origin: np.ndarray, source: int = OBSERVED) -> ClearanceField:
    clearance = np.minimum(clearance, FAR)
    return ClearanceField(origin, SPACING, clearance, np.where(clearance < FAR, source, NOTHING).astype(np.int8))


def open_field(**nodes) -> ClearanceField:
    origin, places = nodes_around(**nodes)
    return field_from(np.full(places.shape[:2], np.inf), origin)


def faces_field(*faces, source: int = OBSERVED, **nodes) -> ClearanceField:
    """Flat faces that the disc's centre keeps behind: (bearing out of the wall [rad], distance from (0, 0) [m])."""
    origin, places = nodes_around(**nodes)
    normals = np.array([[np.cos(bearing), np.sin(bearing)] for bearing, _ in faces])
    depths = places @ normals.T + np.array([distance for _, distance in faces])
    return field_from(depths.min(axis=-1), origin, source)


def pillars_field(*pillars, **nodes) -> ClearanceField:
    """Round pillars x, y, radius [m]."""
    origin, places = nodes_around(**nodes)
    distances = [np.hypot(places[..., 0] - x, places[..., 1] - y) - radius - RADIUS for x, y, radius in pillars]
    return field_from(np.min(distances, axis=0), origin)


def joined(*fields: ClearanceField) -> ClearanceField:
    """All that is in either of some fields over the same nodes."""
    which = np.argmin([field.clearance for field in fields], axis=0)
    clearance = np.min([field.clearance for field in fields], axis=0)
    return replace(fields[0], clearance=clearance, source=np.choose(which, [field.source for field in fields]))


def scene_over(field: ClearanceField, goal=(1.2, 0.0), settings: Settings = SETTINGS, free=None) -> Scene:
    """The scene over a field; free wherever the disc fits, if nothing else is said."""
    goal = np.array(goal, dtype=float)
    free = field.clearance >= 0.0 if free is None else free
    return scene_of(field, free, shortest_paths(field, goal, goal, settings), settings)


def law_and_price(settings: Settings) -> tuple[Law, Price]:
    return law_of(settings), price_of(settings)


@dataclass(frozen=True, eq=False)
class Rolled:
    """A whole plan as `whole.roll` fills it; what lies beyond n is left over."""

    commands: np.ndarray
    states: np.ndarray
    costs: np.ndarray
    n: int
    j: float
    arrived: bool


def rolled(scene: Scene, settings: Settings, begin, commands, stop_test: bool = False, most: int = 0) -> Rolled:
    """Commands (n, 2) from begin (x, y, vx, vy); room for `most` knots where that is more than n."""
    law, price = law_and_price(settings)
    commands = np.array(commands, dtype=float).reshape(-1, 2)
    n, most = len(commands), max(most, len(commands))
    padded = np.zeros((most, 2))
    padded[:n] = commands
    states, costs = np.zeros((most + 1, 4)), np.zeros(most + 1)
    states[0] = begin
    used, j, arrived = roll(scene, law, price, stop_test, padded, n, states, costs)
    return Rolled(padded, states, costs, used, j, arrived)


def stepped(scene: Scene, law: Law, begin, commands) -> np.ndarray:
    """(n, 10) what `law.step` says step by step under commands (n, 2), one a step."""
    x, y, vx, vy = (float(value) for value in begin)
    near = near_at(scene, x, y)
    rows = []
    for ux, uy in np.asarray(commands, dtype=float):
        row = step(scene.clearance, scene.source, scene.grid, law, x, y, vx, vy, near, ux, uy)
        rows.append(row)
        x, y, vx, vy, near = row[:5]
    return np.array(rows)
