"""A gap that the disc fits through is open, one that is 25 mm narrower is closed."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.local_map import LocalMap
from collplan_core.plan import NoPlan
from collplan_core.time_to_goal_planner.boundary_memory.clearance import INFERRED
from collplan_core.time_to_goal_planner.boundary_memory.update import remember
from collplan_core.time_to_goal_planner.boundary_memory.working import RememberedBoundaries
from collplan_core.time_to_goal_planner.plan_cycle import RolloutMemory, plan_cycle
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import is_reachable
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths
from collplan_core.time_to_goal_planner.way_to_goal import way_to_goal
from collplan_core.worlds import World
from scenes import RADIUS, ROBOT, SETTINGS, TURN, at_rest, box, grown, map_of, rotation, world_of

DISC = 2.0 * RADIUS
BOUNCE = SETTINGS.with_values({"planner.strategy": "bounce"})
HALF = 0.5
"""Half the side of a room that is parted in two [m]."""


class Parted(NamedTuple):
    """A room, parted but for one gap; start and goal lie on either side of it."""

    world: World
    start: np.ndarray
    goal: np.ndarray


@st.composite
def parted_rooms(draw, spare: tuple[float, float]) -> Parted:
    """Rooms turned and shifted at random; the gap between two posts is wider than the disc by some of `spare` [m]."""
    size, askew = draw(st.floats(0.03, 0.12)), draw(st.floats(-0.05, 0.05))
    post = np.array([askew, 0.5 * (DISC + draw(st.floats(*spare))) + size])
    outer = HALF + 0.1
    corners = [
        (-outer, -outer, outer, -HALF), (-outer, HALF, outer, outer), (-outer, -outer, -HALF, outer),
        (HALF, -outer, outer, outer), (askew - 0.01, post[1], askew + 0.01, HALF),
        (-askew - 0.01, -HALF, -askew + 0.01, -post[1]),
    ]  # fmt: skip
    turn, shift = rotation(draw(st.floats(0.0, TURN))), np.array([draw(st.floats(-0.03, 0.03)) for _ in range(2)])
    # askew, the posts are as far apart as they would be side by side
    posts = [side * post[1] * post / np.hypot(*post) @ turn.T + shift for side in (1.0, -1.0)]
    world = world_of([box(*each) @ turn.T + shift for each in corners], [(*place, size) for place in posts])
    return Parted(world, *(turn @ (x, 0.0) + shift for x in (-0.36, 0.36)))


def seen(room: Parted, seed: int, n: int) -> tuple[RememberedBoundaries, LocalMap]:
    """What is remembered after scans from n free places on both sides, the last one at the start; its map."""
    rng, memory = np.random.default_rng(seed), None
    blocked = grown(room.world, RADIUS + 0.01)
    places = 0.5 * (room.start + room.goal) + rng.uniform(-0.6, 0.6, (40 * n, 2))
    near = shapely.Point(0.5 * (room.start + room.goal)).buffer(0.45)
    free = [p for p in places if not blocked.intersects(shapely.Point(p)) and near.intersects(shapely.Point(p))][:n]
    for k, place in enumerate([*free, room.start]):
        local_map = replace(map_of(room.world, place), stamp=0.05 * (k + 1))
        memory = remember(memory, local_map, ROBOT, SETTINGS.remembered)
    assert memory is not None
    return memory, local_map


def way(memory: RememberedBoundaries, position: np.ndarray, goal: np.ndarray):
    paths = shortest_paths(memory.field, goal, position, SETTINGS)
    return way_to_goal(memory, paths, position, SETTINGS)


@given(room=parted_rooms((0.0005, 0.06)), seed=st.integers(0, 99), n=st.integers(0, 12))
def test_a_gap_that_the_disc_fits_through_is_open_whatever_was_seen_of_it(room, seed, n):
    memory, _ = seen(room, seed, n)
    found = way(memory, room.start, room.goal)
    assert found is not None
    assert is_reachable(found[1], room.start)


@given(room=parted_rooms((-0.06, -0.025)), seed=st.integers(0, 99))
def test_a_gap_that_the_disc_does_not_fit_through_by_25_mm_is_closed_once_it_was_seen(room, seed):
    memory, _ = seen(room, seed, 30)
    assert way(memory, room.start, room.goal) is None
    # nor does it open where the robot stands before it
    blocked = grown(room.world, RADIUS + 0.001)
    line = room.start + np.linspace(0.0, 1.0, 60)[:, None] * (room.goal - room.start)
    touching = next(k for k, place in enumerate(line) if blocked.intersects(shapely.Point(place))) - 1
    assert way(memory, line[touching], room.goal) is None


CHICANE = [
    box(-0.6, -0.6, 0.6, -0.5), box(-0.6, 0.5, 0.6, 0.6), box(-0.6, -0.6, -0.5, 0.6), box(0.6, -0.6, 0.7, 0.6),
    box(0.0, -0.5, 0.03, 0.2), box(0.23, -0.2, 0.26, 0.5),
]  # fmt: skip
"""A room with two thin walls across, one beside the other: between them is 2 cm more than the disc."""


def test_solid_that_is_only_inferred_gives_way_before_a_goal_is_given_up():
    start, goal = np.array([-0.35, 0.0]), np.array([0.43, 0.0])
    memory, local_map = None, None
    for k, place in enumerate([(-0.3, -0.3), (-0.35, 0.3), start]):
        local_map = replace(map_of(world_of(CHICANE), place), stamp=0.05 * (k + 1))
        memory = remember(memory, local_map, ROBOT, SETTINGS.remembered)
    assert (memory.field.source == INFERRED).any()
    assert not is_reachable(shortest_paths(memory.field, goal, start, SETTINGS), start)
    boundaries, _, gap = way(memory, start, goal)
    assert gap is None
    assert not (boundaries.field.source == INFERRED).any()
    assert (boundaries.field.clearance < 0.0).any()
    before = RolloutMemory(remembered=memory, map_stamp=local_map.stamp)
    plan, _ = plan_cycle(before, local_map, at_rest(start), goal, BOUNCE)
    assert np.isfinite(plan.positions).all()


def test_what_was_seen_is_never_given_up_with_what_is_inferred():
    closed = [*CHICANE[:-1], box(0.0, 0.15, 0.03, 0.5)]
    start, goal = np.array([-0.35, 0.0]), np.array([0.43, 0.0])
    local_map = map_of(world_of(closed), start)
    for settings in (BOUNCE, BOUNCE.with_values({"time_to_goal.grid_spacing": 0.01})):  # the least that there may be
        with pytest.raises(NoPlan, match="closed off"):
            plan_cycle(None, local_map, at_rest(start), goal, settings)
