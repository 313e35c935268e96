"""The age of messages whose sender has another clock."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.control.smallest_delay import DRIFT, STEP, SmallestDelay


def ages(messages):
    delay, found = SmallestDelay(), []
    for sent, now in messages:
        delay, age = delay.measured(sent, now)
        found.append(age)
    return found


@settings(derandomize=True, deadline=None, max_examples=200)
@given(st.lists(st.floats(0.0, 3.0), min_size=2, max_size=50), st.floats(-1e6, 1e6))
def test_whatever_the_clocks_an_age_is_the_delay_beyond_the_smallest(delays, offset):
    messages = [(10.0 * n + offset, 10.0 * n + 0.001 + delay) for n, delay in enumerate([0.0, *delays])]
    drift = DRIFT * 11.0 * len(messages)
    for age, delay in zip(ages(messages), [0.0, *delays], strict=True):
        assert delay - drift - 1e-6 <= age <= delay + 1e-6


@pytest.mark.parametrize("step", [-3600.0, 3600.0, -2 * STEP, 2 * STEP])
def test_a_step_of_the_senders_clock_spoils_one_message_at_most(step):
    messages = [(0.05 * n + (step if n >= 50 else 0.0), 0.05 * n) for n in range(100)]
    late = [age for age in ages(messages) if age > 0.01]
    assert len(late) == (step < 0)


def test_a_clock_that_is_slow_by_less_than_the_drift_makes_no_age():
    messages = [(0.05 * n * (1 - 0.9 * DRIFT), 0.05 * n) for n in range(20000)]
    assert max(ages(messages)) < 1e-4
