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


def test_noise_has_the_deviation_of_the_record_and_so_many_beams_are_lost():
    for distance in (0.3, 1.0, 11.0):
        measured = noisy(np.full(DRAWS, distance), LD19, random())
        deviation = hypot(LD19.noise, LD19.noise_share * distance)
        # four standard errors of a mean, of a standard deviation and of a share
        assert np.nanmean(measured) == pytest.approx(distance, abs=4 * deviation / sqrt(DRAWS)), distance
        assert np.nanstd(measured) == pytest.approx(deviation, rel=4 / sqrt(2 * DRAWS)), distance
        assert np.isnan(measured).mean() == pytest.approx(LD19.lost, abs=4 * sqrt(LD19.lost / DRAWS)), distance
    # the data sheet's
    assert np.nanstd(noisy(np.full(DRAWS, 0.3), LD19, random())) == pytest.approx(0.010, rel=0.03)


def test_beams_that_meet_nothing_or_begin_inside_stay_so_and_no_range_is_negative():
    beams, sound = np.array([np.inf, -np.inf]), replace(LD19, lost=0.0)
    np.testing.assert_array_equal(noisy(beams, sound, random()), beams)
    assert noisy(np.full(DRAWS, 0.005), sound, random()).min() == 0.0


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
    # a quarter turn aside it meets one surface
    assert blended(world, np.zeros((1, 2)), np.array([pi]), LD19)[0] == pytest.approx(3.0, rel=1e-4)


def test_a_beam_half_past_the_last_surface_shows_that_surface():
    wall = np.array([[2.0, -1.0], [2.1, -1.0], [2.1, 0.0], [2.0, 0.0]])
    open_world = replace(room(wall), walled=False)
    assert blended(open_world, np.zeros((1, 2)), np.zeros(1), LD19)[0] == pytest.approx(2.0, rel=1e-4)
    assert blended(open_world, np.zeros((1, 2)), np.array([pi]), LD19)[0] == np.inf


# ---- sweep


def test_each_beam_of_a_moving_robot_is_an_ideal_one_from_its_own_pose():
    for world in ["corridor", "random:3"]:
        world = load_world(world)
        start = np.array(world.start)

        def motion(stamp, start=start):
            return replace(driving(stamp), position=start + stamp * np.array([0.5, 0.1]))

        times = EXACT.beam_times(0.3)
        poses = np.array([(*motion(t).position.tolist(), motion(t).yaw) for t in times])
        scan = swept_scan(world, poses, 0.3, EXACT, Lidar(), random())
        ideal = Lidar(n_beams=EXACT.n_beams, range_min=EXACT.range_min, range_max=EXACT.range_max)
        expected = [simulate_scan(world, motion(t), ideal).ranges[k] for k, t in enumerate(times)]
        np.testing.assert_allclose(scan.ranges, expected, rtol=1e-9)


def test_scans_follow_each_other_and_come_late_by_the_latency():
    for period in [0.001, 0.005, 0.01, 0.1]:
        pairs = scans_of(Sweeps(room(), LD19, Lidar(), 0), period * np.arange(round(1.0 / period)))
        stamps = np.array([scan.stamp for _, scan in pairs])
        assert len(stamps) in (8, 9), period
        np.testing.assert_allclose(stamps, LD19.sweep_time * np.arange(len(stamps)), atol=1e-9)
        late = np.array([came for came, _ in pairs]) - stamps - LD19.sweep_time
        assert (late > LD19.latency - 1e-6).all(), period
        assert (late < LD19.latency + period + 1e-6).all(), period


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


def test_equal_seeds_give_equal_scans():
    def ranges(seed):
        pairs = scans_of(Sweeps(room(), LD19, Lidar(), seed), np.arange(0.0, 0.5, 0.01))
        return np.array([scan.ranges for _, scan in pairs])

    np.testing.assert_array_equal(ranges(3), ranges(3))
    assert (ranges(3) != ranges(4)).mean() > 0.9
    assert (ranges(3)[0] != ranges(3)[1]).mean() > 0.9


def test_after_silence_or_a_clock_set_a_sweep_begins_anew():
    for jump in [-5.0, 0.4, 100.0]:
        sweeps = Sweeps(room(), LD19, Lidar(), 0)
        before = np.arange(0.0, 0.16, 0.01)
        assert len(scans_of(sweeps, before, lambda t: replace(driving(0.0), stamp=t))) == 1, jump
        after = 0.15 + jump + np.arange(0.0, 0.25, 0.01)
        (came, scan), *_ = scans_of(sweeps, after, lambda t: replace(driving(0.0), stamp=t))
        assert scan.stamp == pytest.approx(after[0]), jump
        assert came == pytest.approx(after[0] + LD19.sweep_time + LD19.latency, abs=0.0101), jump


# ---- what the parameter names


def test_low_cost_is_the_shipped_record():
    lidar = Lidar(sensor="low_cost", angle_min=radians(90.0))
    _, scan = scans_of(sweeps_of(room(), lidar, 0), np.arange(0.0, 0.2, 0.01))[0]
    assert (len(scan.ranges), scan.range_min, scan.range_max) == (LD19.n_beams, LD19.range_min, LD19.range_max)
    assert scan.angle_min == radians(90.0)
    assert scan.time_increment * len(scan.ranges) == pytest.approx(LD19.sweep_time)
    assert scan.angle_increment * len(scan.ranges) == pytest.approx(tau)
    assert sweeps_of(room(), Lidar(), 0) is None


def test_the_yaw_between_poses_goes_the_shortest_way():
    def turning(stamp):
        return State(stamp, np.zeros(2), np.zeros(2), (3.0 + 3.0 * stamp + pi) % tau - pi)

    scan = scans_of(Sweeps(room(), EXACT, Lidar(), 0), np.arange(0.0, 0.2, 0.01), turning)[0][1]
    angles = scan.angles + 3.0 + 3.0 * EXACT.beam_times(scan.stamp)
    expected = 3.0 / np.maximum(abs(np.cos(angles)), abs(np.sin(angles)))
    np.testing.assert_allclose(scan.ranges, expected, rtol=1e-9)
