"""Remembered boundaries along drives through worlds: what must hold whatever the world is."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.parameters import Lidar
from collplan_core.state import State
from collplan_core.time_to_goal_planner.boundary_memory.clearance import FAR, INFERRED, NOTHING, OBSERVED
from collplan_core.time_to_goal_planner.boundary_memory.record import RememberedBoundaries
from collplan_core.time_to_goal_planner.boundary_memory.update import remember
from collplan_core.worlds import World, load_world
from collplan_core.worlds.raycast import simulate_scan
from scenes import RADIUS, ROBOT, SETTINGS, TURN, grown, obstacles, uneven_world, unit

REMEMBERED = SETTINGS.remembered
QUICK = settings(derandomize=True, deadline=None, max_examples=12, print_blob=True)


def wander(world: World, start: np.ndarray, steps: int, rng: np.random.Generator) -> list[np.ndarray]:
    """Positions 5 cm apart, straight on until something is in the way."""
    blocked = grown(world, RADIUS + 0.005)
    shapely.prepare(blocked)
    positions, heading = [start], rng.uniform(0.0, TURN)
    while len(positions) < steps:
        onward = positions[-1] + 0.05 * unit(heading)
        if shapely.intersects_xy(blocked, *onward):
            heading = rng.uniform(0.0, TURN)
        else:
            positions.append(onward)
    return positions


def maps_along(world: World, positions, noise: float = 0.0) -> Iterator[LocalMap]:
    """A local map at each position, 0.05 s apart."""
    rng = np.random.default_rng(0)
    for k, position in enumerate(positions):
        state = State(0.05 * (k + 1), np.array(position, dtype=float), np.zeros(2), 0.0)
        scan = simulate_scan(world, state, Lidar())
        believed = replace(state, position=state.position + noise * rng.standard_normal(2))
        yield build_local_map(scan, believed, ROBOT, SETTINGS.local_map)


def remembered(maps, memory: RememberedBoundaries | None = None) -> RememberedBoundaries:
    for local_map in maps:
        memory = remember(memory, local_map, ROBOT, REMEMBERED)
    assert memory is not None
    return memory


def lines(segments: np.ndarray) -> shapely.Geometry:
    return shapely.multilinestrings(list(shapely.linestrings(segments.reshape(-1, 2, 2))))


def nodes_of(memory: RememberedBoundaries) -> np.ndarray:
    n = len(memory.field.clearance)
    return memory.field.origin + memory.field.spacing * np.stack(np.mgrid[:n, :n], axis=-1)


def on_boundary(pieces: np.ndarray, boundary: shapely.Geometry) -> np.ndarray:
    x0, y0, x1, y1 = pieces.T
    points = shapely.points([x0, 0.5 * (x0 + x1), x1], [y0, 0.5 * (y0 + y1), y1])
    return shapely.distance(boundary, points).max(axis=0) < 1e-6


def assert_nothing_seen_is_lost(world: World, positions) -> None:
    boundary = shapely.boundary(obstacles(world))
    shapely.prepare(boundary)
    memory, seen = None, np.zeros((0, 2))
    for k, local_map in enumerate(maps_along(world, positions)):
        memory = remember(memory, local_map, ROBOT, REMEMBERED)
        if k % 5 and k + 1 < len(positions):
            continue
        lost = shapely.distance(lines(memory.pieces), shapely.points(seen))
        assert lost.max(initial=0.0) < REMEMBERED.spacing
        assert (lost > 2e-3).sum() <= 0.01 * len(lost)
        middles = memory.pieces[on_boundary(memory.pieces, boundary)].reshape(-1, 2, 2).mean(axis=1)
        seen = np.unique(np.vstack([seen, middles]).round(6), axis=0)
    assert len(seen) > 50
    nodes, field = nodes_of(memory), memory.field
    observed = field.source == OBSERVED
    true = shapely.distance(boundary, shapely.points(nodes[observed])) - RADIUS
    early = (true - field.clearance[observed])[true > 0.0]
    assert early.max() < 6e-3
    assert np.quantile(early, 0.98) < 1e-3
    assert not (memory.free & observed & (field.clearance < 0.0)).any()


def test_in_a_world_that_stands_still_nothing_seen_is_forgotten():
    """No piece on a true boundary is forgotten while the robot stays near; nothing observed is off a boundary."""
    for spec in ("random:3", "l:9", "baffles:4", "serpentine:2", "pillars:8"):
        world, rng = load_world(spec), np.random.default_rng(1)
        assert_nothing_seen_is_lost(world, wander(world, np.array(world.start), 40, rng))


def assert_is_of_the_pieces(memory: RememberedBoundaries, rng: np.random.Generator) -> None:
    """The field is the exact distance to the pieces and to what is inferred behind them, whatever came and went."""
    field = memory.field
    behind = memory.pieces[memory.solid_behind] - 0.12 * np.tile(memory.normals[memory.solid_behind], 2)
    nodes = rng.integers(0, len(field.clearance), (1500, 2))
    near = np.argwhere(field.clearance < FAR)
    nodes = np.vstack([nodes, near[rng.integers(0, len(near), 1500)]])
    points = shapely.points(field.origin + nodes * field.spacing)
    observed = shapely.distance(lines(memory.pieces), points) - RADIUS
    inferred = shapely.distance(lines(behind), points) - RADIUS if len(behind) else np.full(len(points), np.inf)
    values, sources = field.clearance[tuple(nodes.T)], field.source[tuple(nodes.T)]
    np.testing.assert_allclose(values, np.minimum(FAR, np.minimum(observed, inferred)), atol=1e-9)
    assert (sources[values == FAR] == NOTHING).all()
    assert (sources[observed < np.minimum(FAR, inferred) - 1e-9] == OBSERVED).all()
    assert (sources[inferred < np.minimum(FAR, observed) - 1e-9] == INFERRED).all()


@QUICK
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.004, 0.03]))
def test_the_field_is_that_of_the_pieces_left(seed: int, noise: float):
    """Noise makes pieces come and go; halfway the world changes altogether."""
    rng = np.random.default_rng(seed)
    memory = None
    for world in (uneven_world(rng), uneven_world(rng)):
        positions = wander(world, np.zeros(2), 12, rng)
        memory = remembered(maps_along(world, positions, noise), memory)
    assert_is_of_the_pieces(memory, rng)


def test_the_grid_moves_along_with_the_robot():
    clutter = [np.array([[x, 0.3], [x + 0.2, 0.3], [x + 0.1, 0.5]]) for x in np.arange(-0.5, 5.0, 0.6)]
    world = World("row", tuple(clutter), np.zeros((0, 3)), (-9.0, -9.0, 9.0, 9.0), False)
    positions = [np.array([x, 0.0]) for x in np.arange(0.0, 4.2, 0.1)]
    memory = remembered(maps_along(world, positions))
    field = memory.field
    assert field.origin[0] > -3.0 + 1.0
    np.testing.assert_allclose(field.origin / field.spacing, np.round(field.origin / field.spacing), atol=1e-9)
    assert_is_of_the_pieces(memory, np.random.default_rng(0))
    assert memory.pieces[:, 0].min() > positions[-1][0] - 0.5 * REMEMBERED.side - 0.05
    behind = np.round((np.array([2.0, 0.0]) - field.origin) / field.spacing).astype(int)
    assert memory.free[tuple(behind)], "what was seen free is carried along"
