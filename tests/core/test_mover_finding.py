"""What moves, from scans alone: walls never do, a disc that walks is found, followed and left out of the map."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.local_map.seen import seen_surfaces
from collplan_core.loop.sensed_scans import SensedScans
from collplan_core.movers.finding import MoverMemory, find_movers
from collplan_core.movers.record import MOVES, STANDS, Movers, SortedReturns
from collplan_core.parameters import Lidar, Settings
from collplan_core.scans.wall_lines import on_wall_lines, range_noise
from collplan_core.state import State
from collplan_core.time_to_goal_planner.boundary_memory.update import remember
from collplan_core.worlds import Mover, parse_world
from collplan_core.worlds.gait import discs_at, gait_of
from collplan_core.worlds.instant_lidar import InstantLidar, MoverHistory
from collplan_core.worlds.movers import PERSON

SETTINGS = Settings()
PERIOD = 0.05
ROOM = parse_world(
    {
        "name": "room",
        "bounds": [0.0, 0.0, 3.0, 2.0],
        "polygons": [[[1.0, 0.0], [1.1, 0.0], [1.1, 1.0], [1.0, 1.0]]],
        "circles": [{"center": [2.2, 1.5], "radius": 0.05}],
    },
    "room",
)
HALL = parse_world({"name": "hall", "bounds": [-10.0, -10.0, 13.0, 13.0]}, "hall")
WALK = np.array([0.4, 1.6])
"""Where a mover begins to walk along x."""
STOP = WALK + np.array([0.7, 0.0])


def drive(n: int, velocity=(0.0, 0.0), begin=(0.5, 0.4), yaw_rate: float = 0.0) -> list[State]:
    times = PERIOD * np.arange(n)
    return [State(t, np.array(begin) + t * np.array(velocity), np.array(velocity), yaw_rate * t) for t in times]


def scans_of(states, noise: float = 0.0, seed: int = 0, mover=lambda t: None, radius: float = 0.12, world=ROOM):
    history, scans = MoverHistory(), []
    lidar = InstantLidar(world, Lidar(range_noise=noise), seed, history)
    for state in states:
        place = mover(state.stamp)
        places = np.array([] if place is None else place).reshape(-1, 2)
        history.add(state.stamp, np.column_stack([places, np.full(len(places), radius)]))
        scans.append(lidar.scan(state))
    return scans


def sort_all(states, scans) -> list[SortedReturns]:
    memory, found = MoverMemory(), []
    for state, scan in zip(states, scans, strict=True):
        noise = range_noise(scan)
        seen = seen_surfaces(on_wall_lines(scan, noise), state)
        returns, memory = find_movers(memory, scan, noise, seen, state, SETTINGS.movers)
        found.append(returns)
    return found


@given(
    velocity=st.tuples(st.floats(-0.2, 1.0), st.floats(-0.2, 1.0)),
    yaw_rate=st.floats(-1.0, 1.0),
    noise=st.sampled_from([0.0, 0.003, 0.01]),
    seed=st.integers(0, 1000),
)
def test_walls_tips_and_posts_never_move(velocity, yaw_rate, noise, seed):
    states = drive(9, velocity, (0.6, 0.6), yaw_rate)
    for returns in sort_all(states, scans_of(states, noise, seed)):
        assert not (returns.kinds == MOVES).any()
        assert not len(returns.movers)


def walks(speed: float):
    return lambda t: WALK + np.array([max(0.0, t - 0.3) * speed, 0.0])


@pytest.mark.parametrize("speed", [0.3, 0.6, 1.2])
def test_a_disc_that_sets_out_is_followed(speed):
    states, walk = drive(21), walks(speed)
    found = [returns.movers for returns in sort_all(states, scans_of(states, mover=walk))]
    known = next(movers.stamp for movers in found if len(movers))
    assert known <= 0.3 + 0.08 / speed + 0.2
    last: Movers = found[-1]
    assert len(last) == 1
    assert np.hypot(*(last.positions[0] - walk(last.stamp))) < 0.06
    np.testing.assert_allclose(last.velocities[0], (speed, 0.0), atol=0.25)
    assert len({int(movers.numbers[0]) for movers in found if len(movers)}) == 1


@pytest.mark.parametrize("leaves", [np.inf, 3.0])
def test_who_walked_in_is_no_wall_even_if_hidden_until_its_place_is_seen_free(leaves):
    def mover(t):
        return None if t > leaves else walks(0.7)(min(t, 1.3))

    states = drive(110)
    scans = scans_of(states, mover=mover)
    towards = STOP - states[0].position
    ahead = np.abs(scans[0].angles - np.arctan2(*towards[::-1])) < 0.4
    hidden = [replace(s, ranges=np.where(ahead & (2.0 < s.stamp < 4.0), np.nan, s.ranges)) for s in scans]
    found = sort_all(states, hidden)
    assert all(len(returns.movers) == 1 for returns in found[20:79])
    np.testing.assert_allclose(found[70].movers.positions[0], STOP, atol=0.06)
    assert len(found[-1].movers) == (leaves == np.inf)
    near = [np.abs(s.ranges - np.hypot(*towards)) < 0.2 for s in scans]
    if leaves == np.inf:
        assert not any(
            (returns.kinds[of & ahead] == STANDS).any() for returns, of in zip(found[20:], near[20:], strict=True)
        )


def test_a_person_is_one_mover_with_two_legs_and_one_velocity():
    way = np.array([[0.3, 1.5], [2.8, 1.5]])
    person = Mover(0.06, way, 0.8, to_and_fro=False, delay=0.3, kind=PERSON)
    gait, states = gait_of(person), drive(40)
    found = sort_all(states, scans_of(states, mover=lambda t: discs_at(gait, t), radius=0.06, world=HALL))
    walking = [returns.movers for returns in found[16:]]
    assert all(len(movers) in (1, 2) and len(movers.whole[0]) == 1 for movers in walking)
    assert sum(len(movers) == 2 for movers in walking) > 0.7 * len(walking)
    both = [movers for movers in walking if len(movers) == 2]
    assert np.ptp([movers.velocities[:, 0] for movers in both], axis=1).max() == 0.0
    np.testing.assert_allclose(np.mean([movers.velocities[0] for movers in both], axis=0), (0.8, 0.0), atol=0.15)
    for movers in both:
        middle, radius = movers.whole[1][0, :2], movers.whole[1][0, 4]
        assert (np.hypot(*(movers.positions - middle).T) + movers.radii < radius + 1e-9).all()


def test_the_map_and_the_memory_are_without_what_moves():
    sensed, states, walk = SensedScans(0.5), drive(24), walks(0.6)
    memory, seen_there = None, []
    for state, scan in zip(states, scans_of(states, mover=walk), strict=True):
        sensed.take_pose(state, state.stamp, SETTINGS)
        assert [reason for reason, _ in sensed.take_scan(scan, state.stamp, SETTINGS)] == [""]
        placed = sensed.newest_mapped(SETTINGS)
        memory = remember(memory, placed.local_map, SETTINGS.robot, SETTINGS.remembered)
        middles = 0.5 * (memory.pieces[:, :2] + memory.pieces[:, 2:])
        seen_there.append(int((np.abs(middles[:, 1] - WALK[1]) < 0.11).sum()))
    assert len(sensed.movers) == 1
    away = np.hypot(*(placed.local_map.walls[:, :2] - walk(state.stamp)).T)
    assert away.min() > 0.12
    inner = (middles > 0.05).all(axis=1) & (middles < (2.95, 1.95)).all(axis=1) & (middles[:, 0] < 0.95)
    assert not (inner & (middles[:, 1] > 1.2)).any()


def test_what_stood_stands_for_a_new_goal_too():
    sensed, states = SensedScans(0.5), drive(10)
    for state, scan in zip(states, scans_of(states), strict=True):
        sensed.take_pose(state, state.stamp, SETTINGS)
        sensed.take_scan(scan, state.stamp, SETTINGS)
    sensed.forget()
    later = drive(11)[-1]
    sensed.take_pose(later, later.stamp, SETTINGS)
    sensed.take_scan(scans_of([later])[0], later.stamp, SETTINGS)
    assert (sensed.newest_mapped(SETTINGS).local_map.returns.kinds == STANDS).mean() > 0.95
