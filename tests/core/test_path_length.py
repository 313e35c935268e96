"""The length of a run's path, exact and measured."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.evaluation.path_length import measured_path_length, path_length


def test_a_polyline_worked_by_hand():
    assert path_length(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]])) == pytest.approx(6.0)
    assert path_length(np.zeros((1, 2))) == 0.0
    assert measured_path_length(np.zeros(1), np.zeros((1, 2))) == 0.0


@given(st.integers(2, 400), st.floats(-3.0, 3.0), st.floats(0.05, 1.5))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_a_straight_line_keeps_its_length(n, angle, speed):
    times = 1.7e9 + 0.01 * np.arange(n)
    positions = speed * (times - times[0])[:, None] * np.array([np.cos(angle), np.sin(angle)])
    assert measured_path_length(times, positions) == pytest.approx(path_length(positions), rel=1e-3)


def test_noise_adds_little_where_the_plain_sum_adds_much():
    for seed in range(3):
        times = 0.01 * np.arange(600)
        angle = 0.8 * times
        exact = np.column_stack([np.cos(angle), np.sin(angle)])
        noisy = exact + np.random.default_rng(seed).normal(0.0, 0.002, exact.shape)
        length = path_length(exact)
        assert path_length(noisy) > 1.04 * length, seed
        assert measured_path_length(times, noisy) == pytest.approx(length, rel=0.01), seed


def test_lost_poses_are_bridged():
    times = np.delete(0.01 * np.arange(300), np.arange(100, 115))
    positions = np.column_stack([0.8 * times, 0.2 * times])
    assert measured_path_length(times, positions) == pytest.approx(path_length(positions), rel=1e-3)
