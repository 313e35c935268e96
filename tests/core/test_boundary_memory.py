"""Remembered boundaries: what scans of hand-made scenes leave, and what holds along drives through any world."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.movers.record import ALL_STANDS, NEW, STANDS
from collplan_core.parameters import Lidar
from collplan_core.state import State
from collplan_core.time_to_goal_planner.boundary_memory import update
from collplan_core.time_to_goal_planner.boundary_memory.clearance import (
    FAR,
    INFERRED,
    NOTHING,
    OBSERVED,
    PENDING,
    clearance_at,
    source_at,
)
from collplan_core.time_to_goal_planner.boundary_memory.field import FIRST_SIDE
from collplan_core.time_to_goal_planner.boundary_memory.update import INFERRED_INSET, known_boundaries, remember
from collplan_core.time_to_goal_planner.boundary_memory.working import RememberedBoundaries
from collplan_core.worlds import World, load_world, world_segments
from collplan_core.worlds.raycast import simulate_scan
from scenes import (
    RADIUS,
    ROBOT,
    SETTINGS,
    TURN,
    box,
    grown,
    map_of,
    map_of_ranges,
    obstacles,
    star_map,
    uneven_world,
    unit,
    world_of,
)

REMEMBERED = SETTINGS.remembered
HALF_SIDE = SETTINGS.local_map.half_side
WALL = box(-3.0, 0.4, 3.0, 0.6)  # its face at y = 0.4 is seen from below


def stamped(local_map: LocalMap, stamp: float) -> LocalMap:
    return replace(local_map, stamp=stamp)


def seen_from(world: World, positions, settings=REMEMBERED, memory=None, first: int = 1) -> RememberedBoundaries:
    for k, position in enumerate(positions):
        memory = remember(memory, stamped(map_of(world, position), 0.05 * (first + k)), ROBOT, settings)
    assert memory is not None
    return memory


def clearance(memory: RememberedBoundaries, x: float, y: float) -> float:
    f = memory.field
    return clearance_at(f.clearance, f.grid, x, y)


def source(memory: RememberedBoundaries, x: float, y: float) -> int:
    return source_at(memory.field.source, memory.field.grid, x, y)


def is_free(memory: RememberedBoundaries, x: float, y: float) -> bool:
    i, j = np.round((np.array([x, y]) - memory.field.origin) / memory.field.spacing).astype(int)
    return bool(memory.free[i, j])


def test_solid_is_inferred_behind_a_wall_but_not_at_the_ends_of_what_was_seen():
    memory = seen_from(world_of([box(-0.3, 0.4, 0.3, 2.0)]), [(0.0, 0.0)])
    face = 0.4 - RADIUS
    for x in (0.0, 0.1, -0.15):
        assert [source(memory, x, face + deep) for deep in (0.02, 0.25)] == [OBSERVED, INFERRED]
    beside = memory.pieces[memory.solid_behind][:, [0, 2]]
    assert np.abs(beside).max() <= 0.3 - INFERRED_INSET + 0.5 * REMEMBERED.spacing + 1e-9
    assert np.abs(beside).max() >= 0.3 - INFERRED_INSET - 2.0 * REMEMBERED.spacing


def test_solid_inferred_within_a_thin_wall_goes_once_both_sides_were_seen():
    thin = world_of([box(-0.4, 0.0, 0.4, 0.05)])
    turn = [(-0.55, -0.25), (-0.6, 0.025), (-0.55, 0.3)]
    around = [(0.0, -0.3), (-0.3, -0.3), *turn, (-0.3, 0.35), (0.0, 0.35), (0.3, 0.35)]
    before = seen_from(thin, around[:1])
    assert source(before, 0.0, 0.2) == INFERRED
    for order in (around, around[::-1]):
        memory = seen_from(thin, order)
        assert not memory.solid_behind[np.abs(memory.pieces[:, [0, 2]]).max(axis=1) < 0.2].any()
        for x in (-0.2, 0.0, 0.2):
            assert clearance(memory, x, 0.05 + RADIUS + 0.03) == pytest.approx(0.03, abs=1e-6)
            assert source(memory, x, 0.05 + RADIUS) == OBSERVED
            assert source(memory, x, -RADIUS) == OBSERVED


def test_a_moved_box_is_forgotten_once_its_old_place_is_seen_through():
    before, after = world_of([box(0.3, -0.1, 0.5, 0.1)]), world_of([box(0.3, 0.5, 0.5, 0.7)])
    memory = seen_from(before, [(0.0, 0.0), (0.02, 0.0)])
    assert clearance(memory, 0.25, 0.0) < 0.0
    memory = seen_from(after, [(0.04, 0.0)], memory=memory, first=3)
    assert clearance(memory, 0.25, 0.0) < 0.0  # one scan may err
    memory = seen_from(after, [(0.06, 0.0)], memory=memory, first=4)
    assert clearance(memory, 0.25, 0.0) == FAR
    assert is_free(memory, 0.25, 0.0)
    assert clearance(memory, 0.4, 0.42) < 0.0
    assert memory.pieces[:, [1, 3]].min() > 0.4


def test_a_wall_seen_elsewhere_by_drift_is_one_wall():
    for drift in (-0.02, 0.02, 0.04):
        memory = seen_from(world_of([WALL]), [(0.0, 0.0), (0.02, 0.0)])
        moved = world_of([WALL + np.array([0.0, drift])])
        memory = seen_from(moved, [(0.04, 0.0), (0.06, 0.0)], memory=memory, first=3)
        for x in np.linspace(-0.35, 0.4, 16):
            assert clearance(memory, x, 0.28) == pytest.approx(0.4 + drift - 0.28 - RADIUS, abs=1e-9)
        ahead = np.abs(memory.pieces[:, [0, 2]]).max(axis=1) < 0.35
        assert np.allclose(memory.pieces[ahead][:, [1, 3]], 0.4 + drift)


def test_memory_is_bounded_by_number_and_what_was_seen_longest_ago_goes(monkeypatch):
    monkeypatch.setattr(update, "MOST_PIECES", 100)
    memory = seen_from(world_of([WALL]), [(x, 0.0) for x in np.arange(0.0, 2.0, 0.05)])
    assert len(memory.pieces) == 100
    assert memory.pieces[:, [0, 2]].min() > 0.2
    assert clearance(memory, 1.9, 0.3) == pytest.approx(0.01, abs=1e-9)
    assert clearance(memory, 0.0, 0.3) == FAR


def test_a_scan_without_anything_or_of_nothing_but_invalid_ranges_is_taken():
    one_beam = np.full(360, np.nan)
    one_beam[7] = np.inf
    for ranges in (np.full(360, np.inf), np.full(360, -np.inf), np.full(360, 1e-6), one_beam):
        strange = map_of_ranges(ranges)
        for memory in (None, seen_from(world_of([WALL]), [(0.0, 0.0)])):
            after = remember(memory, stamped(strange, 0.1), ROBOT, REMEMBERED)
            assert np.isfinite(after.field.clearance).all()
            assert np.isfinite(after.pieces).all()
    memory = remember(None, star_map(np.full(360, 0.5)), ROBOT, REMEMBERED)
    assert (len(memory.pieces), is_free(memory, 0.3, 0.3), is_free(memory, 0.4, 0.4)) == (0, True, False)


def test_a_known_map_is_exact_as_large_as_its_walls_and_free_where_nothing_is_touched():
    world = load_world("pillars:4")
    memory = known_boundaries(world_segments(world), np.array([1.2, 1.2]), ROBOT, REMEMBERED)
    walls = shapely.multilinestrings(list(shapely.linestrings(world_segments(world).reshape(-1, 2, 2))))
    f = memory.field
    nodes = np.random.default_rng(0).integers(0, len(f.clearance), (4000, 2))
    true = shapely.distance(walls, shapely.points(f.origin + nodes * f.spacing)) - RADIUS
    np.testing.assert_allclose(f.clearance[tuple(nodes.T)], np.minimum(true, FAR), atol=1e-9)
    assert ((f.source == OBSERVED) == (f.clearance < FAR)).all()
    assert (memory.free == (f.clearance >= 0.0)).all()
    assert not memory.solid_behind.any()
    long = known_boundaries(np.array([[-7.0, 1.0, 9.0, 1.0]]), np.array([0.0, 0.0]), ROBOT, REMEMBERED)
    assert [clearance(long, x, 0.9) for x in (8.99, -6.99)] == pytest.approx([0.01, 0.01], abs=1e-9)
    assert known_boundaries(np.zeros((0, 4)), np.array([0.3, 0.2]), ROBOT, REMEMBERED).free.all()


QUICK = settings(max_examples=12)


def wander(world: World, start: np.ndarray, steps: int, rng: np.random.Generator) -> list[np.ndarray]:
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
    for spec in ("random:3", "l:9", "baffles:4", "serpentine:2", "pillars:8"):
        world, rng = load_world(spec), np.random.default_rng(1)
        assert_nothing_seen_is_lost(world, wander(world, np.array(world.start), 40, rng))


def assert_is_of_the_pieces(memory: RememberedBoundaries, rng: np.random.Generator) -> None:
    field = memory.field
    behind = memory.pieces[memory.solid_behind] - 0.12 * np.tile(memory.normals[memory.solid_behind], 2)
    nodes = rng.integers(0, field.clearance.shape, (1500, 2))
    near = np.argwhere(field.clearance < FAR)
    if len(near):
        nodes = np.vstack([nodes, near[rng.integers(0, len(near), 1500)]])
    points = shapely.points(field.origin + nodes * field.spacing)
    standing, pending, unseen = (memory.pieces[memory.kinds == kind] for kind in (OBSERVED, PENDING, INFERRED))
    of_kinds = standing, pending, np.vstack([behind, unseen])
    distances = [
        shapely.distance(lines(each), points) if len(each) else np.full(len(points), np.inf) for each in of_kinds
    ]
    to = np.array(distances) - RADIUS
    values, sources = field.clearance[tuple(nodes.T)], field.source[tuple(nodes.T)]
    np.testing.assert_allclose(values, np.minimum(FAR, to.min(axis=0)), atol=1e-9)
    assert (sources[values == FAR] == NOTHING).all()
    for k, kind in enumerate((OBSERVED, PENDING, INFERRED)):
        nearest = to[k] < np.minimum(FAR, np.delete(to, k, axis=0).min(axis=0)) - 1e-9
        assert (sources[nearest] == kind).all()


@QUICK
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.004, 0.03]))
def test_the_field_is_that_of_the_pieces_left(seed: int, noise: float):
    rng = np.random.default_rng(seed)
    memory = None
    for world in (uneven_world(rng), uneven_world(rng)):
        positions = wander(world, np.zeros(2), 12, rng)
        memory = remembered(maps_along(world, positions, noise), memory)
    assert_is_of_the_pieces(memory, rng)


def of_kinds(local_map: LocalMap, stands) -> LocalMap:
    kinds = np.where(np.broadcast_to(stands, len(local_map.view)), STANDS, NEW)
    return replace(local_map, returns=replace(ALL_STANDS, kinds=kinds))


@QUICK
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.004]), st.sampled_from([0.0, 0.02, 0.3]))
def test_the_field_says_what_stands_what_is_in_sight_and_what_was_only_seen(seed: int, noise: float, share: float):
    rng = np.random.default_rng(seed)
    world = uneven_world(rng)
    maps = list(maps_along(world, wander(world, np.zeros(2), 12, rng), noise))
    memory = None
    for local_map in maps:
        memory = remembered([of_kinds(local_map, rng.random(len(local_map.view)) < share)], memory)
        assert (memory.kinds[memory.seen < local_map.stamp] != PENDING).all()
        assert (memory.kinds[memory.seen == local_map.stamp] != INFERRED).all()
    assert_is_of_the_pieces(memory, rng)


def test_by_hand_a_wall_is_pending_until_it_stands_and_as_inferred_once_it_is_out_of_sight_before():
    wall, hidden, place = world_of([WALL]), world_of([WALL, box(-0.6, 0.1, 0.6, 0.15)]), (0.0, 0.4 - RADIUS)
    seen, kinds = None, []
    for world, stands in ((wall, False), (wall, False), (hidden, False), (wall, False), (wall, True), (hidden, False)):
        seen = remembered([stamped(of_kinds(map_of(world), stands), 0.05 * len(kinds))], seen)
        kinds.append(source(seen, *place))
        assert clearance(seen, *place) == pytest.approx(0.0, abs=1e-9)
    assert kinds == [PENDING, PENDING, INFERRED, PENDING, OBSERVED, OBSERVED]


ROW = [np.array([[x, 0.3], [x + 0.2, 0.3], [x + 0.1, 0.5]]) for x in np.arange(-0.5, 5.0, 0.6)]


def along_a_row(settings=REMEMBERED) -> RememberedBoundaries:
    world = World("row", tuple(ROW), np.zeros((0, 3)), (-9.0, -9.0, 9.0, 9.0), False)
    memory = None
    for local_map in maps_along(world, [np.array([x, 0.0]) for x in np.arange(0.0, 4.2, 0.1)]):
        memory = remember(memory, local_map, ROBOT, settings)
    field = memory.field
    np.testing.assert_allclose(field.origin / field.spacing, np.round(field.origin / field.spacing), atol=1e-9)
    assert_is_of_the_pieces(memory, np.random.default_rng(0))
    assert is_free(memory, 2.0, 0.0)  # what was seen free is carried along
    return memory


def test_the_grid_grows_with_the_way_and_all_seen_stays():
    memory = along_a_row()
    first, last = memory.field.origin, memory.field.origin + memory.field.spacing * np.array(memory.free.shape)
    np.testing.assert_allclose(first, -0.5 * FIRST_SIDE, atol=1e-6)
    assert last[0] > 4.1 + HALF_SIDE
    assert last[1] == pytest.approx(0.5 * FIRST_SIDE, abs=0.03)
    assert memory.pieces[:, 0].min() < -0.4
    assert is_free(memory, 0.0, 0.0)


def test_a_grid_as_long_as_it_may_be_ends_behind_the_robot():
    memory = along_a_row(replace(REMEMBERED, side=6.0))
    size = memory.field.spacing * (np.array(memory.free.shape) - 1)
    np.testing.assert_allclose(size, 6.0, atol=1e-6)
    assert memory.field.origin[0] > -2.0
    assert memory.field.origin[0] + size[0] > 4.1 + HALF_SIDE
    middles = 0.5 * (memory.pieces[:, 0] + memory.pieces[:, 2])
    assert middles.min() > memory.field.origin[0] - memory.field.spacing
