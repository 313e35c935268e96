"""Movers: where they are when nothing hinders them, what is refused, their files, and how a LIDAR sees them."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Lidar
from collplan_core.state import State
from collplan_core.worlds import Mover, World, WorldError, read_world, save_world, world_text
from collplan_core.worlds.file import parse_text
from collplan_core.worlds.gait import TURN, discs_at, gait_of
from collplan_core.worlds.instant_lidar import HELD, InstantLidar, MoverHistory
from collplan_core.worlds.movers import HIP, PERSON, place_at, turned
from collplan_core.worlds.raycast import cast_beams, simulate_scan
from collplan_core.worlds.spinning_lidar import LD19, Sweeps

NO_CIRCLES = np.zeros((0, 3))
coordinates = st.tuples(st.integers(0, 40), st.integers(0, 40)).map(lambda p: np.array(p) / 10)


def world_of(*movers: Mover) -> World:
    return World("w", (), NO_CIRCLES, (0.0, 0.0, 4.0, 4.0), movers=movers)


@st.composite
def movers(draw) -> Mover:
    way = draw(st.lists(coordinates, min_size=1, max_size=5, unique_by=tuple))
    numbers = st.floats(0.0, 3.0)
    return Mover(0.1, np.array(way), draw(st.floats(0.1, 2.0)), draw(st.booleans()), draw(numbers), draw(numbers))


def off_the_way(mover: Mover, place: np.ndarray) -> float:
    if len(mover.way) == 1:
        return float(np.hypot(*(place - mover.way[0])))
    a, b = mover.way[:-1], mover.way[1:]
    share = np.clip(((place - a) * (b - a)).sum(axis=1) / ((b - a) ** 2).sum(axis=1), 0.0, 1.0)
    return float(np.hypot(*(a + share[:, None] * (b - a) - place).T).min())


@given(movers(), st.floats(0.0, 100.0), st.floats(0.0, 1.0))
def test_a_mover_stays_on_its_way_and_is_no_faster_than_its_speed(mover, time, later):
    place, then = np.array(place_at(mover, time)), np.array(place_at(mover, time + later))
    assert off_the_way(mover, place) < 1e-9
    assert np.hypot(*(then - place)) <= mover.speed * later + 1e-9


@given(movers(), st.floats(0.0, 20.0), st.floats(0.0, 1.0))
def test_a_mover_that_turns_back_goes_the_way_it_came(mover, time, later):
    mover = Mover(mover.radius, mover.way, mover.speed, True, mover.delay, mover.pause)
    if len(mover.way) == 1:
        return
    back = turned(mover, mover.delay + later + time)
    np.testing.assert_allclose(place_at(mover, back), place_at(mover, mover.delay + later + time), atol=1e-6)
    np.testing.assert_allclose(place_at(mover, back + later), place_at(mover, mover.delay + time), atol=1e-6)


def test_delay_pause_and_ends_by_hand():
    way = np.array([[1.0, 1.0], [2.0, 1.0], [2.0, 3.0]])
    once = Mover(0.1, way, 0.5, to_and_fro=False, delay=1.0, pause=2.0)
    # 2 s to the corner, 2 s there, 4 s to the end
    for time, place in ((0.5, (1, 1)), (2.0, (1.5, 1)), (3.5, (2, 1)), (4.9, (2, 1)), (7.0, (2, 2)), (99.0, (2, 3))):
        assert place_at(once, time) == pytest.approx(place)
    for_ever = Mover(0.1, way, 0.5, delay=1.0, pause=2.0)
    # at the end at 9 s, from there at 11 s, at the corner from 15 to 17 s, at the first from 19 to 21 s
    for time, place in ((10.0, (2, 3)), (16.0, (2, 1)), (18.0, (1.5, 1)), (20.0, (1, 1)), (22.0, (1.5, 1))):
        assert place_at(for_ever, time) == pytest.approx(place)
    one_round = replace(for_ever, rounds=1)
    for time, place in ((10.0, (2, 3)), (18.0, (1.5, 1)), (22.0, (1, 1)), (50.0, (1, 1))):
        assert place_at(one_round, time) == pytest.approx(place)


def test_bad_movers_are_refused_and_named():
    good = "radius: 0.1, speed: 0.5, way: [[1, 1], [2, 1]]"
    for bad, words in (
        ("radius: 0, speed: 0.5, way: [[1, 1]]", r"movers[1].radius: got 0, expected a number above 0 [m]"),
        (f"{good}, delay: -1", "movers[1].delay: got -1, expected a number from 0 [s]"),
        (f"{good}, sped: 1", "movers[1].sped: unknown key, expected radius, way, speed"),
        ("radius: 0.1, speed: 1, way: [[1, 1], [1, 1]]", "movers[1].way: got [[1.0, 1.0], [1.0, 1.0]], expected"),
        ("radius: 0.1, speed: 1, way: [[1, 1], [5, 1]]", "movers[1].way[1]: [5.0, 1.0] is outside the arena"),
        (f"{good}, times: [0, true]", "movers[1].times: got [0, True], expected as many rising times"),
        ("radius: 0.1, speed: 1, way: [[3, 3]]", "movers[1].way[0]: [3.0, 3.0] is inside circles[0]"),
    ):
        text = f"bounds: [0, 0, 4, 4]\ncircles: [{{center: [3, 3], radius: 0.2}}]\nmovers: [{{{good}}}, {{{bad}}}]\n"
        with pytest.raises(WorldError, match=re.escape(words)):
            parse_text(text, "w.yaml", "w")
    with pytest.raises(WorldError, match=r"movers\[0\]: got 7, expected a mapping"):
        parse_text("bounds: [0, 0, 4, 4]\nmovers: [7]\n", "w.yaml", "w")


@given(st.lists(movers(), max_size=3))
def test_a_file_gives_the_same_movers(tmp_path_factory, given_movers):
    world, path = world_of(*given_movers), tmp_path_factory.mktemp("world") / "w.yaml"
    save_world(world, path)
    found = read_world(path)
    assert world_text(found) == world_text(world)
    for mover, same in zip(given_movers, found.movers, strict=True):
        assert place_at(mover, 7.3) == place_at(same, 7.3)
    assert ("movers" in world_text(world)) == bool(given_movers)


@given(st.lists(st.tuples(st.floats(1.0, 3.0), st.floats(1.0, 3.0), st.floats(0.05, 0.3)), max_size=3))
def test_a_disc_is_seen_as_a_circle_that_stands_there(rows):
    discs = np.array(rows).reshape(-1, 3)
    state = State(0.0, np.array([0.5, 0.6]), np.zeros(2), 0.3)
    standing = World("w", (), discs, (0.0, 0.0, 4.0, 4.0))
    expected = simulate_scan(standing, state, Lidar()).ranges
    np.testing.assert_array_equal(simulate_scan(world_of(), state, Lidar(), discs).ranges, expected)
    angles, origins = np.linspace(-3.0, 3.0, 50), np.tile(state.position, (50, 1))
    moved = cast_beams(world_of(), origins, angles, np.tile(discs, (50, 1, 1)))
    np.testing.assert_array_equal(moved, cast_beams(standing, origins, angles))


def test_each_lidar_sees_a_mover_where_it_is_at_the_instant_of_its_beams():
    history, mover = MoverHistory(), Mover(0.2, np.array([[1.0, 2.0], [3.0, 2.0]]), 4.0)
    assert history.at_each(np.zeros(3)).shape == (3, 0, 3)
    for time in np.arange(0.0, 0.3, 0.01):
        history.add(float(time), np.array([[*place_at(mover, time), mover.radius]]))
    state = State(0.105, np.array([1.42, 1.0]), np.zeros(2), np.pi / 2)
    # at 0.105 s its centre is at 1.42, straight ahead
    lidar = Lidar(n_beams=31, angle_min=-0.1, angle_span=0.2)
    assert InstantLidar(world_of(), lidar, 0, history).scan(state).ranges[15] == pytest.approx(0.8)
    sweeps = Sweeps(world_of(), LD19, Lidar(angle_min=-np.pi / 2), 0, history)
    scans = [sweeps.take_pose(State(time, np.array([1.2, 1.0]), np.zeros(2), 0.0)) for time in (0.0, 0.05, 0.1, 0.12)]
    (scan,) = (scan for scan in scans if scan is not None)
    # the beam to +y is halfway through the sweep of 0.1 s, where the centre is at 1.2; one 0.02 s before sees the wall
    hits = scan.ranges[225 - 2 : 225 + 3]
    assert np.nanmedian(hits) == pytest.approx(0.8, abs=0.03)


def test_a_history_holds_its_ends_and_begins_anew():
    history, disc = MoverHistory(), np.array([[1.0, 1.0, 0.1]])
    history.add(0.0, disc)
    history.add(HELD, disc + np.array([[1.0, 0.0, 0.0]]))
    x = history.at_each(np.array([-1.0, 0.25 * HELD, 9.0]))[:, 0, 0]
    np.testing.assert_allclose(x, [1.0, 1.25, 2.0])
    history.add(2.5 * HELD, disc)
    np.testing.assert_allclose(history.at_each(np.array([0.0]))[0], disc)
    history.add(0.5 * HELD, 2.0 * disc)  # a clock set back
    np.testing.assert_allclose(history.at_each(np.array([2.5 * HELD]))[0], 2.0 * disc)


STEP = 0.002


def legs_of(mover: Mover, times: np.ndarray) -> np.ndarray:
    gait = gait_of(mover)
    return np.array([discs_at(gait, time) for time in times])


WAYS = st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3)), min_size=2, max_size=5)


@given(WAYS, st.floats(0.2, 1.5), st.booleans())
@settings(max_examples=40, deadline=None)
def test_one_leg_stands_while_the_other_swings_and_none_leaps(way, speed, to_and_fro):
    way = np.array([point for k, point in enumerate(way) if k == 0 or point != way[k - 1]], dtype=float)
    mover = Mover(0.06, way, speed, to_and_fro=to_and_fro, kind=PERSON)
    legs = legs_of(mover, np.arange(0.0, 6.0, STEP))
    speeds = np.hypot(*np.moveaxis(np.diff(legs, axis=0), -1, 0)) / STEP
    assert np.median(speeds.min(axis=1)) < 1e-9
    assert speeds.max() < 2.0 * speed * (1.0 + HIP * np.pi / (2.0 * TURN)) + 1e-6  # it turns by pi at most
    places = np.array([place_at(mover, time) for time in np.arange(0.0, 6.0, STEP)])
    assert np.hypot(*np.moveaxis(legs - places[:, None], -1, 0)).max() < 1.0


def test_on_a_straight_way_the_legs_are_beside_it_and_their_mean_is_the_place():
    mover = Mover(0.06, np.array([[0.0, 0.0], [9.0, 0.0]]), 1.3, to_and_fro=False, kind=PERSON)
    times = np.arange(1.0, 5.0, 0.01)
    legs = legs_of(mover, times)
    np.testing.assert_allclose(legs[:, 0, 1], HIP)
    np.testing.assert_allclose(legs[:, 1, 1], -HIP)
    np.testing.assert_allclose(legs[:, :, 0].mean(axis=1), 1.3 * times, atol=1e-9)
    assert np.ptp(legs[:, 0, 0] - legs[:, 1, 0]) == pytest.approx(1.4, rel=0.02)  # a step ahead, a step behind


def test_a_recorded_walk_is_at_its_places_at_its_times():
    times = np.array([0.0, 1.0, 4.0])
    way = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.5]])
    mover = Mover(0.06, way, 1.0, kind=PERSON, times=times)
    assert [place_at(mover, time) for time in (0.5, 1.0, 2.5, 9.0)] == [(0.5, 0.0), (1.0, 0.0), (1.0, 0.75), (1.0, 1.5)]
    with pytest.raises(ValueError, match=r"times: got \[1.0, 0.0, 2.0\], expected as many rising times"):
        Mover(0.06, way, 1.0, times=[1.0, 0.0, 2.0])
    # who is twice at one place stands there, on two legs that stand
    stood = Mover(0.06, way[[0, 1, 1, 2]], 1.0, kind=PERSON, times=[0.0, 1.0, 3.0, 4.0])
    assert np.ptp(legs_of(stood, np.arange(1.0, 3.0, 0.01)), axis=0).max() < 1e-9
    assert place_at(stood, 3.5) == (1.0, 0.75)
    with pytest.raises(ValueError, match="kind: got 'dog', expected one of disc, person"):
        Mover(0.06, way, 1.0, kind="dog")
