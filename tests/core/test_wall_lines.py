"""Noisy ranges and the straight walls behind them: what noise takes away, what is left, and what is never touched."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.scan import Scan
from collplan_core.scans.wall_lines import FARTHEST, MOST, on_wall_lines, range_noise
from collplan_core.worlds import World
from scenes import TURN, at_rest, box, scan_of, world_of

NOISES = st.floats(0.002, 0.02)
SEEDS = st.integers(0, 2**31)


@st.composite
def rooms(draw) -> World:
    boxes = []
    for _ in range(draw(st.integers(0, 4))):
        x, y = draw(st.floats(0.2, 0.6)), draw(st.floats(0.2, 0.6))
        corner = np.array([draw(st.sampled_from([-1, 1])) * x, draw(st.sampled_from([-1, 1])) * y])
        far = corner + np.sign(corner) * draw(st.floats(0.05, 0.4))
        boxes.append(box(*np.minimum(corner, far), *np.maximum(corner, far)))
    half = draw(st.floats(0.7, 1.4)), draw(st.floats(0.7, 1.4))
    return world_of(boxes, bounds=(-half[0], -half[1], *half), walled=True)


def with_noise(scan: Scan, noise: float, seed: int = 0) -> Scan:
    errors = noise * np.random.default_rng(seed).standard_normal(len(scan.ranges))
    return replace(scan, ranges=np.maximum(scan.ranges + errors, 0.0))


def straightened(scan: Scan) -> Scan:
    return on_wall_lines(scan, range_noise(scan))


def spread(scan: Scan, exact: Scan) -> float:
    """Below which 95 % of the errors of finite ranges are [m]: of the rest some straddle an edge."""
    hits = np.isfinite(exact.ranges)
    return float(np.quantile(np.abs(scan.ranges[hits] - exact.ranges[hits]), 0.95))


@given(world=rooms(), noise=NOISES, seed=SEEDS)
def test_the_noise_is_found_from_the_scan(world, noise, seed):
    assert range_noise(with_noise(scan_of(world, at_rest()), noise, seed)) == pytest.approx(noise, rel=0.4)


@given(world=rooms())
def test_exact_walls_have_none_and_stay_to_the_last_bit(world):
    scan = scan_of(world, at_rest())
    assert range_noise(scan) < 1e-9
    assert straightened(scan) is scan


@given(world=rooms(), noise=NOISES, seed=SEEDS)
def test_it_falls_to_less_than_two_thirds(world, noise, seed):
    exact = scan_of(world, at_rest())
    noisy = with_noise(exact, noise, seed)
    assert spread(straightened(noisy), exact) < 2.0 / 3.0 * spread(noisy, exact)


@given(distance=st.floats(0.1, 1.0), tilt=st.floats(-3.0, 3.0), seed=SEEDS)
def test_a_wall_close_by_is_neither_nearer_nor_farther(distance, tilt, seed):
    """Mean over many scans: inverse ranges alone would be off by 4 mm at 0.1 m."""
    angles = TURN * np.arange(360) / 360
    ahead = np.cos(angles - tilt)
    exact = Scan(0.0, 0.0, TURN / 360, 0.02, 5.0, np.where(ahead > 0.5, distance / np.maximum(ahead, 0.5), np.inf))
    errors = [
        np.mean(straightened(with_noise(exact, 0.01, seed + k)).ranges[ahead > 0.5] - exact.ranges[ahead > 0.5])
        for k in range(30)
    ]
    assert abs(np.mean(errors)) < 0.0015


def test_by_hand_what_stands_out_of_a_wall_stays():
    """With 10 mm of noise 3 cm show over ten beams, not yet over three; docs/limits.md says so."""
    for n_beams, height in [(1, 0.08), (10, 0.03)]:
        angles = TURN * np.arange(360) / 360
        flat = 0.6 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
        there = (np.arange(360) >= 15) & (np.arange(360) < 15 + n_beams)
        exact = Scan(0.0, 0.0, TURN / 360, 0.02, 5.0, flat - np.where(there, height, 0.0))
        found = [straightened(with_noise(exact, 0.01, seed)).ranges for seed in range(8)]
        assert (flat - np.mean(found, axis=0))[there].mean() > 0.8 * height, (n_beams, height)


def test_by_hand_a_lost_beam_is_filled_on_a_wall_and_stays_lost_elsewhere():
    exact = scan_of(world_of([box(0.3, -0.2, 0.5, 0.2)], bounds=(-1.0, -1.0, 1.0, 1.0), walled=True), at_rest())
    ahead = int(np.argmin(exact.ranges))
    edge = ahead + int(np.argmax(np.diff(exact.ranges[ahead:]) > 0.1))
    lost = [ahead, 20, 21, edge]
    noisy = with_noise(exact, 0.01).ranges.copy()
    noisy[lost] = np.nan
    found = straightened(replace(exact, ranges=noisy)).ranges
    assert found[ahead] == pytest.approx(exact.ranges[ahead], abs=0.01)
    assert np.isnan(found[[20, 21, edge]]).all()
    # a beam that straddles an edge meets what is near, also where its hit is on a line with one hit of each surface
    for share in (0.5, 0.4):
        noisy[edge + 1] = exact.ranges[edge] + share * (exact.ranges[edge + 2] - exact.ranges[edge])
        found = straightened(replace(exact, ranges=noisy)).ranges
        assert found[edge + 1] == pytest.approx(exact.ranges[edge], abs=0.03)


@pytest.mark.parametrize("elsewhere", [np.inf, 0.5])
@pytest.mark.parametrize("share", [0.3, 0.4, 0.5, 0.6])
def test_a_hit_between_two_surfaces_counts_as_the_near_one(share, elsewhere):
    """Such hits closed gaps: at a share of 0.4 on a line with a hit of each, or beside the farthest hit of the turn."""
    angles, end = TURN * np.arange(450) / 450, 82
    beside, behind = 0.286 / np.maximum(np.cos(angles), 0.1), 1.02 / np.maximum(np.sin(angles), 0.1)
    exact = np.where(np.arange(450) <= end, beside, np.where(np.arange(450) < 113, behind, elsewhere))
    exact[end + 1] = exact[end] + share * (exact[end + 2] - exact[end])
    for seed in range(20):
        found = straightened(with_noise(Scan(0.0, 0.0, TURN / 450, 0.02, 5.0, exact), 0.01, seed)).ranges
        assert found[end + 1] == pytest.approx(exact[end], abs=0.045), seed


@st.composite
def any_scan(draw) -> Scan:
    n = draw(st.integers(2, 800))
    span = draw(st.floats(0.2, TURN))
    random = np.random.default_rng(draw(SEEDS))
    ranges = 0.5 + 0.4 * np.sin(np.arange(n) * draw(st.floats(0.0, 1.0))) + draw(st.floats(0.0, 0.1)) * random.random(n)
    for value in (np.inf, -np.inf, np.nan, 4.0):
        ranges[random.random(n) < draw(st.floats(0.0, 0.2))] = value
    ranges[0] = 0.5
    return Scan(0.0, 0.0, draw(st.sampled_from([-1.0, 1.0])) * span / n, 0.02, 5.0, ranges)


@given(scan=any_scan())
def test_hits_stay_hits_and_are_no_farther_than_noise_explains(scan):
    found = straightened(scan)
    hits = np.isfinite(scan.ranges)
    single = np.isnan(scan.ranges) & np.roll(hits, 1) & np.roll(hits, -1)
    others = ~hits & ~single
    np.testing.assert_array_equal(found.ranges[others], scan.ranges[others])
    assert np.isfinite(found.ranges[hits]).all()
    most = FARTHEST * min(range_noise(scan), MOST)
    moved = found.ranges[hits] - scan.ranges[hits]
    assert moved.max() <= most + 1e-12
    # nearer only where a beam straddles an edge: to what a neighbour met
    near = np.flatnonzero(hits)[moved < -most - 1e-12]
    off = [np.abs(np.roll(scan.ranges, k)[near] - found.ranges[near]) for k in (-2, -1, 1, 2)]
    assert (np.nanmin(np.reshape(off, (4, -1)), axis=0, initial=np.inf) <= most + 1e-12).all()
    assert replace(found, ranges=scan.ranges).angle_increment == scan.angle_increment


@given(world=rooms(), noise=NOISES, seed=SEEDS, first=st.integers(0, 359))
def test_neither_the_first_beam_nor_the_sense_of_turning_nor_a_last_beam_that_repeats_the_first_matters(
    world, noise, seed, first
):
    """RPLIDAR and YDLIDAR repeat it, and begin anywhere in the room."""
    scan = with_noise(scan_of(world, at_rest()), noise, seed)
    straight = straightened(scan)
    rolled = replace(scan, ranges=np.roll(scan.ranges, first))
    turned = straightened(rolled)
    np.testing.assert_allclose(turned.ranges, np.roll(straight.ranges, first), atol=1e-9)
    back = straightened(replace(scan, ranges=scan.ranges[::-1], angle_increment=-scan.angle_increment))
    assert spread(back, replace(straight, ranges=straight.ranges[::-1])) < noise
    again = rolled.ranges[0] + 0.5 * noise
    found = straightened(replace(rolled, ranges=np.append(rolled.ranges, again)))
    np.testing.assert_array_equal(found.ranges, np.append(turned.ranges, again))
