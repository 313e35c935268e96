"""The low-cost spinning LIDAR: noise, losses, edges, and each beam from where the robot was at its instant."""

from dataclasses import replace
from math import hypot, pi, radians, sqrt, tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Lidar
from collplan_core.sensing.spinning_lidar import LD19, blended, noisy, swept_scan
from collplan_core.sensing.sweeps import Sweeps, sweeps_of
from collplan_core.state import State
from collplan_core.worlds import World, load_world
from collplan_core.worlds.raycast import simulate_scan

EXACT = replace(LD19, noise=0.0, noise_share=0.0, lost=0.0, divergence=0.0)
"""The sensor without errors, so that nothing but the sweep is left."""
FEW = settings(derandomize=True, deadline=None, max_examples=25)
DRAWS = 200_000


def room(*polygons) -> World:
    corners = tuple(np.array(polygon, dtype=float) for polygon in polygons)
    return World("room", corners, np.zeros((0, 3)), (-3.0, -3.0, 3.0, 3.0), True)


def random(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def driving(stamp: float) -> State:
    """A robot that drives a straight line and turns evenly, which interpolation meets exactly."""
    return State(stamp, np.array([-0.5 + 0.9 * stamp, 0.3 * stamp]), np.array([0.9, 0.3]), 2.5 * stamp)


def scans_of(sweeps: Sweeps, stamps, motion=driving):
    """Each scan with the stamp of the pose it came with."""
    pairs = [(float(stamp), sweeps.take_pose(motion(float(stamp)))) for stamp in stamps]
    return [(stamp, scan) for stamp, scan in pairs if scan is not None]


# ---- noise


@pytest.mark.parametrize("distance", [0.3, 1.0, 5.0, 11.0])
def test_noise_has_the_deviation_of_the_record(distance):
    measured = noisy(np.full(DRAWS, distance), replace(LD19, lost=0.0), random())
    deviation = hypot(LD19.noise, LD19.noise_share * distance)
    # four standard errors of a mean and of a standard deviation
    assert measured.mean() == pytest.approx(distance, abs=4 * deviation / sqrt(DRAWS))
    assert measured.std() == pytest.approx(deviation, rel=4 / sqrt(2 * DRAWS))


def test_noise_close_by_is_that_of_the_data_sheet():
    assert noisy(np.full(DRAWS, 0.3), LD19, random())[:100].size == 100
    assert np.nanstd(noisy(np.full(DRAWS, 0.3), LD19, random())) == pytest.approx(0.010, rel=0.03)


def test_share_of_lost_beams():
    lost = np.isnan(noisy(np.full(DRAWS, 2.0), LD19, random())).mean()
    assert lost == pytest.approx(LD19.lost, abs=4 * sqrt(LD19.lost / DRAWS))


def test_beams_that_meet_nothing_or_begin_inside_stay_so():
    beams = np.array([np.inf, -np.inf])
    np.testing.assert_array_equal(noisy(beams, replace(LD19, lost=0.0), random()), beams)


def test_no_range_is_negative():
    assert noisy(np.full(DRAWS, 0.005), replace(LD19, lost=0.0), random()).min() == 0.0


# ---- edges


@given(near=st.floats(0.3, 1.5), gap=st.floats(0.05, 1.4), turn=st.floats(-1.0, 1.0))
@FEW
def test_a_beam_on_an_edge_lies_between_the_two_surfaces(near, gap, turn):
    far = near + gap
    # both end where the beam along x passes; the far one lies behind the near one's edge
    world = room(
        [[near, -0.5], [near + 0.01, -0.5], [near + 0.01, 0.0], [near, 0.0]],
        [[far, -0.5], [far + 0.01, -0.5], [far + 0.01, 0.5], [far, 0.5]],
    )
    offset = 0.4 * turn * LD19.divergence
    mixed = blended(world, np.zeros((1, 2)), np.array([offset]), LD19)[0]
    assert near < mixed < far * 1.001
    assert mixed - near > 0.1 * gap
    assert far - mixed > 0.1 * gap


def test_a_beam_on_one_surface_is_not_mixed():
    angles = np.linspace(-0.5, 0.5, 50)
    ranges = blended(room(), np.zeros((50, 2)), angles, LD19)
    np.testing.assert_allclose(ranges, 3.0 / np.cos(angles), rtol=1e-4)


def test_a_beam_half_past_the_last_surface_shows_that_surface():
    wall = np.array([[2.0, -1.0], [2.1, -1.0], [2.1, 0.0], [2.0, 0.0]])
    open_world = replace(room(wall), walled=False)
    assert blended(open_world, np.zeros((1, 2)), np.zeros(1), LD19)[0] == pytest.approx(2.0, rel=1e-4)
    assert blended(open_world, np.zeros((1, 2)), np.array([pi]), LD19)[0] == np.inf


# ---- sweep


@pytest.mark.parametrize("world", ["corridor", "random:3"])
def test_each_beam_of_a_moving_robot_is_an_ideal_one_from_its_own_pose(world):
    world = load_world(world)
    start = np.array(world.start)

    def motion(stamp):
        return replace(driving(stamp), position=start + stamp * np.array([0.5, 0.1]))

    times = EXACT.beam_times(0.3)
    poses = np.array([(*motion(t).position.tolist(), motion(t).yaw) for t in times])
    scan = swept_scan(world, poses, 0.3, EXACT, Lidar(), random())
    ideal = Lidar(n_beams=EXACT.n_beams, range_min=EXACT.range_min, range_max=EXACT.range_max)
    expected = [simulate_scan(world, motion(t), ideal).ranges[k] for k, t in enumerate(times)]
    np.testing.assert_allclose(scan.ranges, expected, rtol=1e-9)


def test_a_robot_at_rest_is_scanned_as_by_the_ideal_sensor():
    world = load_world("random:4")
    state = State(0.0, np.array(world.start, dtype=float), np.zeros(2), 0.7)
    poses = np.tile((*state.position.tolist(), state.yaw), (EXACT.n_beams, 1))
    scan = swept_scan(world, poses, 2.0, EXACT, Lidar(), random())
    ideal = simulate_scan(world, state, Lidar(n_beams=450, range_min=0.02, range_max=12.0))
    np.testing.assert_allclose(scan.ranges, ideal.ranges, rtol=1e-9)
    np.testing.assert_allclose(scan.angles, ideal.angles, atol=1e-12)


def test_times_are_those_of_a_laser_scan():
    """The first beam at the stamp, the last one a step before the next turn."""
    times = LD19.beam_times(4.0)
    assert times[0] == 4.0
    assert times[-1] == pytest.approx(4.1 - LD19.time_increment)
    scan = sweeps_scan()
    assert scan.time_increment == LD19.time_increment
    assert scan.time_increment * len(scan.ranges) == pytest.approx(0.1)
    assert scan.angle_increment * len(scan.ranges) == pytest.approx(tau)


def sweeps_scan():
    return scans_of(Sweeps(room(), LD19, Lidar(), 0), np.arange(0.0, 0.2, 0.01))[0][1]


@pytest.mark.parametrize("period", [0.001, 0.005, 0.01, 0.1])
def test_scans_follow_each_other_and_come_late_by_the_latency(period):
    pairs = scans_of(Sweeps(room(), LD19, Lidar(), 0), period * np.arange(round(1.0 / period)))
    stamps = np.array([scan.stamp for _, scan in pairs])
    assert len(stamps) in (8, 9)
    np.testing.assert_allclose(stamps, LD19.sweep_time * np.arange(len(stamps)), atol=1e-9)
    late = np.array([came for came, _ in pairs]) - stamps - LD19.sweep_time
    assert (late > LD19.latency - 1e-6).all()
    assert (late < LD19.latency + period + 1e-6).all()


def test_a_sweep_uses_the_poses_of_its_own_time():
    world = room([[0.5, -2.0], [0.6, -2.0], [0.6, 2.0], [0.5, 2.0]])
    sweeps = Sweeps(world, EXACT, Lidar(), 0)
    came = scans_of(sweeps, np.arange(0.0, 0.5, 0.01))
    assert len(came) == 4
    for _, scan in came:
        times = EXACT.beam_times(scan.stamp)
        poses = np.array([(*driving(t).position.tolist(), driving(t).yaw) for t in times])
        expected = swept_scan(world, poses, scan.stamp, EXACT, Lidar(), random())
        np.testing.assert_allclose(scan.ranges, expected.ranges, rtol=1e-9)


def test_the_yaw_between_poses_goes_the_shortest_way():
    def turning(stamp):
        return State(stamp, np.zeros(2), np.zeros(2), (3.0 + 3.0 * stamp + pi) % tau - pi)

    scan = scans_of(Sweeps(room(), EXACT, Lidar(), 0), np.arange(0.0, 0.2, 0.01), turning)[0][1]
    angles = scan.angles + 3.0 + 3.0 * EXACT.beam_times(scan.stamp)
    expected = 3.0 / np.maximum(abs(np.cos(angles)), abs(np.sin(angles)))
    np.testing.assert_allclose(scan.ranges, expected, rtol=1e-9)


def test_equal_seeds_give_equal_scans():
    def ranges(seed):
        pairs = scans_of(Sweeps(room(), LD19, Lidar(), seed), np.arange(0.0, 0.5, 0.01))
        return np.array([scan.ranges for _, scan in pairs])

    np.testing.assert_array_equal(ranges(3), ranges(3))
    assert (ranges(3) != ranges(4)).mean() > 0.9
    assert (ranges(3)[0] != ranges(3)[1]).mean() > 0.9


@pytest.mark.parametrize("jump", [-5.0, 0.4, 100.0])
def test_after_silence_or_a_clock_set_a_sweep_begins_anew(jump):
    sweeps = Sweeps(room(), LD19, Lidar(), 0)
    before = np.arange(0.0, 0.16, 0.01)
    assert len(scans_of(sweeps, before, lambda t: replace(driving(0.0), stamp=t))) == 1
    after = 0.15 + jump + np.arange(0.0, 0.25, 0.01)
    (came, scan), *_ = scans_of(sweeps, after, lambda t: replace(driving(0.0), stamp=t))
    assert scan.stamp == pytest.approx(after[0])
    assert came == pytest.approx(after[0] + LD19.sweep_time + LD19.latency, abs=0.0101)


# ---- what the parameter names


def test_ideal_has_no_sweeps():
    assert sweeps_of(room(), Lidar(), 0) is None


def test_low_cost_is_the_shipped_record():
    lidar = Lidar(sensor="low_cost", angle_min=radians(90.0))
    _, scan = scans_of(sweeps_of(room(), lidar, 0), np.arange(0.0, 0.2, 0.01))[0]
    assert (len(scan.ranges), scan.range_min, scan.range_max) == (LD19.n_beams, LD19.range_min, LD19.range_max)
    assert scan.angle_min == radians(90.0)
