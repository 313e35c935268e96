"""What a journal holds comes back bit for bit, and whatever changes in it is noticed."""

import json
import math
import struct
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.goal import Goal
from collplan_core.parameters import Settings
from collplan_core.plan import timed_path
from collplan_core.replay.contents import Altered, Contents, Missing, content_of, reference_to, value_of
from collplan_core.replay.values import JournalError, Reference, decode, encode
from collplan_core.scan import Scan
from collplan_core.state import State

FEW = settings(derandomize=True, deadline=None, max_examples=60)
anything = st.floats()
numbers = st.floats(-1e3, 1e3)
arrays = st.lists(anything, min_size=1, max_size=8).map(np.array)
MANTISSA = 52
"""Bits of a float64 whose change leaves sign and order of magnitude as they are."""


def back(value):
    """The value after it was written as JSON and read."""
    return decode(json.loads(json.dumps(encode(value))))


def bits(*values) -> bytes:
    """The bits of numbers and arrays; every NaN is the same."""
    flat = np.concatenate([np.ravel(value) for value in values]).astype(float)
    return np.where(np.isnan(flat), np.nan, flat).tobytes()


def flipped(array: np.ndarray, place: int, bit: int) -> np.ndarray:
    """A copy with one bit changed in one number."""
    changed = np.array(array, dtype=np.float64)
    changed.reshape(-1).view(np.uint64)[place % changed.size] ^= np.uint64(1 << bit)
    return changed


def scan_of(ranges, stamp: float = 1.0) -> Scan:
    return Scan(stamp, -3.0, 0.1, 0.02, 12.0, np.asarray(ranges, dtype=float), 1e-4)


def plan_of(positions, stamp: float = 1.0):
    positions = np.asarray(positions, dtype=float).reshape(-1, 2)
    return timed_path(stamp, stamp + 0.1 * np.arange(len(positions)), positions, np.zeros_like(positions))


@given(anything)
@FEW
def test_a_float_survives(value):
    assert bits(back(value)) == bits(value)


def test_zeros_keep_their_sign_and_the_smallest_numbers_are_no_zeros():
    for value in (0.0, -0.0, 5e-324, -5e-324, 0.1 + 0.2, 1e308):
        assert struct.pack("<d", back(value)) == struct.pack("<d", value)


@given(arrays)
@FEW
def test_an_array_survives_with_its_shape(array):
    for shaped in (array, array.reshape(-1, 1), np.tile(array, (2, 1)).T):
        found = back(shaped)
        assert (found.shape, found.dtype) == (shaped.shape, np.float64)
        assert bits(found) == bits(shaped)
        found[0] = 1.0  # it can be written to, as an array of a message can


@given(numbers, st.tuples(numbers, numbers), st.tuples(numbers, numbers), numbers)
@FEW
def test_a_state_survives(stamp, position, velocity, yaw):
    found = back(State(stamp, np.array(position), np.array(velocity), yaw))
    assert bits(found.stamp, found.position, found.velocity, found.yaw) == bits(stamp, position, velocity, yaw)


@given(st.binary(min_size=16, max_size=16), anything, st.tuples(anything, anything), st.text())
@FEW
def test_a_goal_survives(identity, stamp, position, status):
    found = back(Goal(identity, stamp, np.array(position), status))
    assert (found.id, found.status) == (identity, status)
    assert bits(found.stamp, found.position) == bits(stamp, position)


def test_settings_survive():
    changed = Settings().with_values({"planner.strategy": "avoid", "limits.fence": (0.0, 0.0, 1.0, 0.0, 1.0, 0.1)})
    assert back(changed) == changed
    assert back(Settings()) == Settings()


def test_what_no_loop_takes_is_refused():
    with pytest.raises(TypeError, match="a journal holds no set"):
        encode({1.0})


@pytest.mark.parametrize(
    "odd", [{}, {"pose": [1.0]}, {"state": [1.0, ""], "goal": []}, {"state": 3}, {"array": [[2], "x"]}]
)
def test_what_is_no_value_is_refused(odd):
    with pytest.raises((JournalError, ValueError)):
        decode(odd)


def test_a_parameter_that_is_no_more_is_named():
    with pytest.raises(ValueError, match=r"planner\.gone"):
        decode({"settings": {"planner.gone": 1.0}})


# ---- scans and plans


@given(st.lists(st.floats(1.0, 1.9), min_size=2, max_size=20), st.integers(0, 19), st.integers(0, MANTISSA - 1))
@FEW
def test_one_bit_of_a_range_makes_it_another_scan(ranges, place, bit):
    scan, other = scan_of(ranges), scan_of(flipped(np.array(ranges), place, bit))
    assert reference_to(scan) == reference_to(scan_of(ranges))
    assert reference_to(other) != reference_to(scan)


@given(st.lists(st.tuples(numbers, numbers), min_size=2, max_size=9), st.integers(0, 17), st.integers(0, 63))
@FEW
def test_one_bit_of_a_position_makes_it_another_plan(positions, place, bit):
    plan, other = plan_of(positions), plan_of(flipped(np.array(positions), place, bit))
    assert (reference_to(other) == reference_to(plan)) == (bits(other.positions) == bits(plan.positions))


def test_other_fields_count_too():
    scan, plan = scan_of([1.0, 2.0]), plan_of([[0.0, 0.0], [1.0, 0.0]])
    scans = [replace(scan, **{name: 1.5 * getattr(scan, name)}) for name in ("stamp", "angle_min", "time_increment")]
    plans = [replace(plan, stamp=2.0), replace(plan, times=plan.times + 1e-9), replace(plan, velocities=plan.positions)]
    references = [reference_to(each) for each in (scan, plan, *scans, *plans)]
    assert len(set(references)) == len(references)


@given(st.lists(st.one_of(st.floats(0.02, 12.0), st.just(math.nan), st.just(math.inf)), min_size=2, max_size=20))
@FEW
def test_a_scan_comes_back_from_its_content(ranges):
    scan = scan_of([1.0, *ranges])
    found = value_of(json.loads(json.dumps(content_of(scan))))
    assert isinstance(found, Scan)
    assert reference_to(found) == reference_to(scan)
    assert bits(found.ranges) == bits(scan.ranges)
    assert not found.ranges.flags.writeable


def test_the_order_in_memory_makes_no_difference():
    positions = np.array([[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]])
    assert reference_to(plan_of(positions)) == reference_to(plan_of(np.asfortranarray(positions)))
    found = value_of(json.loads(json.dumps(content_of(plan_of(np.asfortranarray(positions))))))
    np.testing.assert_array_equal(found.positions, positions)


@pytest.mark.parametrize("content", [{}, {"scan": []}, {"scan": [[1.0], []]}, {"plan": [[1.0, 2.0], []]}, [], "scan"])
def test_what_is_no_content_is_refused(content):
    with pytest.raises(JournalError, match="expected a scan or a plan"):
        value_of(content)


def test_contents_are_found_by_what_stands_for_them():
    contents, scan, other = Contents(), scan_of([1.0, 2.0]), scan_of([1.0, 2.5])
    contents.add(scan)
    assert contents.find(reference_to(scan)) is scan
    with pytest.raises(Altered, match=r"scan of stamp 1\.000000 is not the one that was taken"):
        contents.find(reference_to(other))
    with pytest.raises(Missing, match=r"plan of stamp 3\.250000 .* not in the recording"):
        contents.find(Reference("plan", 3.25, "00"))
    assert contents.plan_at(1.0) is None
    plan = plan_of([[0.0, 0.0], [1.0, 0.0]])
    contents.add(plan)
    assert contents.plan_at(1.0) is plan
    contents.add(other)
    assert (contents.find(reference_to(scan)), contents.find(reference_to(other))) == (scan, other)
