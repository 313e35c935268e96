"""Shape by shape: every width, length and detour within the range that its family states."""

import numpy as np
import pytest
import shapely
from scipy.sparse.csgraph import dijkstra

from collplan_core.worlds import World
from world_measures import (
    BODY_RADIUS,
    ROUNDING,
    SIDE,
    Interval,
    across_start,
    assert_within,
    chord_at,
    chords,
    gaps,
    lengths,
    open_space,
    worlds,
)

CORRIDORS = ("l", "u", "z", "serpentine")


@pytest.mark.parametrize("family", CORRIDORS)
def test_nothing_but_the_corridor_is_free(family):
    corners = {"l": 6, "u": 8, "z": 8, "serpentine": 16}[family]
    for world in worlds(family):
        corridor = open_space(world)
        assert corridor.geom_type == "Polygon"
        assert not corridor.interiors
        assert len(corridor.simplify(1e-9).exterior.coords) - 1 == corners
        assert corridor.distance(shapely.box(*world.bounds).exterior) >= 0.05 - ROUNDING


def test_an_l_has_two_long_arms():
    for world in worlds("l"):
        across = across_start(world)
        arms = [chord_at(world, axis, point) for point in (world.start, world.goal) for axis in (across, 1 - across)]
        first_width, first_length, second_length, second_width = lengths(arms)
        assert_within([first_width, second_width], 0.26, 0.58)
        assert_within([first_length - second_width / 2, second_length - first_width / 2], 1.2, 2.0)


@pytest.mark.parametrize(("family", "septa"), [("u", (0.04, 0.25)), ("z", (0.2, 1.0))])
def test_the_arms_of_u_and_z_lie_side_by_side_and_a_piece_across_joins_them(family, septa):
    for world in worlds(family):
        across = across_start(world)
        arms = sorted(chord_at(world, across, point) for point in (world.start, world.goal))
        (septum,) = gaps(arms)
        assert_within(lengths(arms), 0.26, 0.58)
        assert_within(lengths([septum]), *septa)
        (turn,) = chords(world, 1 - across, sum(septum) / 2)
        assert_within(lengths([turn]), 0.26, 0.58)
        along = [chord_at(world, 1 - across, point) for point in (world.start, world.goal)]
        arm_range = (1.2, 2.0) if family == "u" else (0.8, 1.4)
        assert_within(lengths(along) - lengths([turn])[0] / 2, *arm_range)
        # a u comes back, a z goes on
        back = (world.start - sum(turn) / 2)[1 - across] * (world.goal - sum(turn) / 2)[1 - across] > 0.0
        assert back == (family == "u")


def test_a_serpentine_has_four_rows_and_three_u_turns_at_alternating_ends():
    for world in worlds("serpentine"):
        across = across_start(world)
        low, high = chord_at(world, 1 - across, world.start)
        assert_within(high - low, 1.0, 1.5)
        rows = chords(world, across, (low + high) / 2)
        assert len(rows) == 4
        assert_within(lengths(rows), 0.33, 0.48)
        assert_within(lengths(gaps(rows)), 0.04, 0.12)
        turns = [chords(world, 1 - across, sum(septum) / 2) for septum in gaps(rows)]
        assert [len(turn) for turn in turns] == [1, 1, 1]
        assert_within([lengths(turn)[0] for turn in turns], 0.33, 0.48)
        at_low_end = [turn[0][0] == low for turn in turns]
        assert [turn[0][1] == high for turn in turns] == [not is_low for is_low in at_low_end]
        assert at_low_end in ([True, False, True], [False, True, False])
        assert at_low_end[0] == (world.start[1 - across] > (low + high) / 2)


def test_baffles_leave_gaps_on_alternating_sides():
    for world in worlds("baffles"):
        boxes = np.array([[*p.min(axis=0), *p.max(axis=0)] for p in world.polygons])
        along = int(np.argmin(np.ptp(boxes.reshape(3, 2, 2), axis=1)[0]))
        boxes = boxes[boxes[:, along].argsort()]
        assert_within(boxes[:, along + 2] - boxes[:, along], 0.05, 0.15)
        free = boxes[:, 3 - along] - boxes[:, 1 - along]
        assert_within(SIDE - free, 0.28, 0.58)
        touches_low = (boxes[:, 1 - along] == 0.0).tolist()
        touches_high = (boxes[:, 3 - along] == SIDE).tolist()
        assert touches_low in ([True, False, True], [False, True, False])
        assert touches_high == [not touches for touches in touches_low]
        assert min(world.start[along], world.goal[along]) < boxes[0, along]
        assert max(world.start[along], world.goal[along]) > boxes[2, along + 2]


def pillar_rows(world: World) -> tuple[int, list[Interval]]:
    """The axis from row to row, and the extent of each row on it."""
    boxes = np.array([[*p.min(axis=0), *p.max(axis=0)] for p in world.polygons])
    along = 0 if len(np.unique(boxes[:, 0])) == 2 else 1
    return along, sorted({(box[along], box[along + 2]) for box in boxes.tolist()})


def passages(world: World, along: int, rows: list[Interval]) -> list[list[Interval]]:
    """Narrow and wide passage of each row."""
    return [sorted(chords(world, 1 - along, sum(row) / 2), key=lambda gap: gap[1] - gap[0]) for row in rows]


def plug(along: int, row: Interval, gap: Interval) -> shapely.Geometry:
    low, high = (row[0], gap[0]), (row[1], gap[1])
    return shapely.box(*low, *high) if along == 0 else shapely.box(*low[::-1], *high[::-1])


def way_length(world: World, plugs: list[shapely.Geometry]) -> float:
    """Length of the shortest way of the robot's centre, by a graph of what sees what."""
    solid = shapely.union_all([shapely.Polygon(p) for p in world.polygons] + plugs)
    room = shapely.box(*world.bounds).buffer(-BODY_RADIUS, join_style="mitre")
    free = room.difference(solid.buffer(BODY_RADIUS, quad_segs=2))
    points = np.vstack([world.start, world.goal, shapely.get_coordinates(free)])
    seen = free.buffer(1e-9)
    shapely.prepare(seen)
    i, j = np.triu_indices(len(points), 1)
    visible = shapely.covers(seen, shapely.linestrings(np.stack([points[i], points[j]], axis=1)))
    lengths = np.zeros((len(points), len(points)))
    lengths[i[visible], j[visible]] = np.hypot(*(points[i] - points[j])[visible].T)
    return dijkstra(lengths, directed=False, indices=0)[1]


def test_pillars_have_a_narrow_passage_near_the_way_and_a_wide_one_off_it():
    for world in worlds("pillars"):
        along, rows = pillar_rows(world)
        assert_within(lengths(rows), 0.12, 0.30)
        narrow, wide = zip(*passages(world, along, rows), strict=True)
        assert_within(lengths(narrow), 0.26, 0.43)
        assert_within(lengths(wide), 0.53, 0.68)
        near, far = sorted((world.start, world.goal), key=lambda point: point[along])
        for row, passage in zip(rows, narrow, strict=True):
            share = (sum(row) / 2 - near[along]) / (far - near)[along]
            offset = sum(passage) / 2 - (near + share * (far - near))[1 - along]
            assert_within(abs(offset), 0.35, 0.70)


def test_the_way_through_the_wide_passages_is_a_detour_of_a_tenth_to_a_fifth():
    for world in worlds("pillars")[::2]:
        along, rows = pillar_rows(world)
        narrow, wide = zip(*passages(world, along, rows), strict=True)
        direct = way_length(world, [plug(along, row, gap) for row, gap in zip(rows, wide, strict=True)])
        detour = way_length(world, [plug(along, row, gap) for row, gap in zip(rows, narrow, strict=True)])
        # the family takes the robot for a square
        assert 1.10 - 0.005 <= detour / direct <= 1.22 + 0.005
        assert way_length(world, []) == pytest.approx(direct)
