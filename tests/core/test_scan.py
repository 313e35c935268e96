"""What a scan must be, and what of it is used: masks, speckles, and which way round its angles count."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.loop.input_gate import InputGate, Refusals
from collplan_core.loop.sensed_scans import SensedScans
from collplan_core.parameters import ScanInput, Settings
from collplan_core.scan import Scan, ScanError
from collplan_core.scans.filters import is_masked, upside_down, used_scan, without_speckles
from scenes import at_rest

TURN = 2 * np.pi


def scan(ranges, angle_min=0.0, increment=TURN / 360, range_min=0.02, range_max=5.0, stamp=0.0) -> Scan:
    return Scan(stamp, angle_min, increment, range_min, range_max, np.asarray(ranges))


def test_a_scan_that_cannot_be_used_is_an_error_that_says_why():
    for change, words in [
        ({"ranges": [1.0]}, "2 beams"),
        ({"ranges": np.full(360, np.nan)}, "360 are"),
        ({"ranges": [1.0, -0.5]}, "-0.5"),
        ({"stamp": np.nan}, "finite"),
        ({"increment": -TURN / 300}, "full turn"),
        ({"range_min": -0.1}, "range_min -0.1"),
    ]:
        with pytest.raises(ScanError, match=words):
            scan(**{"ranges": np.ones(360), **change})


def test_ranges_beyond_the_limits_are_no_measurements():
    measured = np.array([0.01, 0.02, 4.99, 5.0, 5.000001, 5.01, 6.0, 65.533, np.nan, np.inf, -np.inf, *np.ones(9)])
    ranges = scan(measured).ranges
    measured[:] = 3.0  # a scan keeps its own
    lost = [np.nan] * 4
    np.testing.assert_array_equal(ranges[:11], [-np.inf, 0.02, 4.99, np.inf, np.inf, *lost, np.inf, -np.inf])


def test_a_scan_in_another_unit_is_refused_and_marks_and_codes_of_many_beams_are_lost_ones():
    measured = np.linspace(0.5, 4.5, 360)
    for lost in (6.0, 65.533, 5.5):
        ranges = scan(np.where(np.arange(360) < 300, lost, measured)).ranges
        assert (np.isnan(ranges) == (np.arange(360) < 300)).all()
    for values, limit in ((1000.0 * measured, 5.0), (100.0 * measured, 5.0), (1000.0 * measured, 5000.0)):
        with pytest.raises(ScanError, match="millimetres"):
            scan(values, range_max=limit)
    with pytest.raises(ScanError, match="above range_max"):
        scan(np.full(360, 6.0))


ranges = st.lists(
    st.one_of(st.floats(0.0, 5.0), st.just(math.inf), st.just(-math.inf), st.just(math.nan)), min_size=30, max_size=60
).map(np.array)


def turn(values) -> Scan:
    values = np.asarray(values, dtype=float)
    return Scan(0.0, -math.pi, math.tau / len(values), 0.0, 10.0, values)


@given(ranges, st.sampled_from([3, 5, 7, 9]), st.booleans())
def test_no_range_is_made_up_and_none_that_is_lost_comes_back(values, width, closed):
    clean = without_speckles(values, width, closed)
    assert np.isnan(clean).tolist() == np.isnan(values).tolist()
    assert set(clean[~np.isnan(clean)]) <= set(values[~np.isnan(values)])


@given(ranges, st.sampled_from([3, 5, 7, 9]), st.integers(0, 59))
def test_where_the_first_beam_follows_the_last_it_does_not_matter_which_is_first(values, width, shift):
    turned = without_speckles(np.roll(values, shift), width, True)
    np.testing.assert_array_equal(turned, np.roll(without_speckles(values, width, True), shift))


def test_a_speckle_goes_and_an_edge_stays():
    values = np.r_[np.full(20, 1.0), np.full(20, 3.0)]
    speckled = values.copy()
    speckled[[5, 28]] = 0.2, 5.0
    np.testing.assert_array_equal(without_speckles(speckled, 3, False), values)
    # what two of three beams show is no speckle
    speckled[[6]] = 0.2
    assert (without_speckles(speckled, 3, False)[5:7] == 0.2).all()


@given(st.floats(-6.0, 6.0), st.floats(0.0, 6.2), st.floats(-20.0, 20.0))
def test_a_mask_goes_counter_clockwise_from_its_first_angle_over_any_full_turns(begin, width, angle):
    inside = is_masked(np.array([angle]), (begin, begin + width))[0]
    away = math.remainder(angle - begin - 0.5 * width, math.tau)
    if abs(abs(away) - 0.5 * width) > 1e-9:
        assert inside == (abs(away) < 0.5 * width)


def test_masks_across_the_back_and_of_a_whole_turn():
    angles = np.radians([-175.0, -90.0, 0.0, 170.0])
    assert is_masked(angles, tuple(np.radians([160.0, -160.0]))).tolist() == [True, False, False, True]
    assert is_masked(angles, (-math.pi, math.pi)).all()
    used = used_scan(turn(np.ones(36)), ScanInput(masked_angles=(-0.2, 0.2, 3.0, -3.0)))
    assert np.flatnonzero(np.isnan(used.ranges)).tolist() == [0, 17, 18, 19]


def test_a_scan_of_which_all_is_masked_is_refused_and_not_a_crash():
    sensors, refusals = InputGate(SensedScans(0.5), counted := Refusals()), counted
    values = Settings().with_values({"scan.masked_angles": [-math.pi, math.pi]})
    sensors.take_pose(at_rest(), 0.0, values)
    sensors.take_scan(turn(np.ones(36)), 0.0, values)
    assert refusals["scan"] == 1
    assert "36 are" in refusals.newest
    assert sensors.sensed.newest_placed() is None


def test_a_scan_is_not_early_where_the_newest_pose_is_late_unless_the_poses_stay_late():
    for lasts, early in ((1, 0), (30, 1)):
        sensors, refusals = InputGate(SensedScans(0.5), counted := Refusals()), counted
        for k in range(20 + lasts):
            late = 0.25 if k >= 20 else 0.0
            sensors.take_pose(replace(at_rest(), stamp=0.05 * k + 1.0), 0.05 * k + 1.0 + late, Settings())
        sensors.take_scan(scan(np.ones(360), stamp=0.05 * k + 1.0 + late), 0.05 * k + 1.0 + late, Settings())
        assert refusals["scan"] == early, refusals.newest


@given(ranges.filter(lambda values: not np.isnan(values).all()))
def test_turned_over_twice_it_is_as_it_was(values):
    scan = turn(values)
    over = upside_down(scan)
    np.testing.assert_allclose(over.angles, -scan.angles)
    again = upside_down(over)
    assert (again.angle_min, again.angle_increment) == (scan.angle_min, scan.angle_increment)
    assert used_scan(scan, ScanInput(mirrored=True)).angle_increment == over.angle_increment
