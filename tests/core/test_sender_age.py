"""The age of the messages of a stream whose sender has another clock."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.control.sender_age import SILENCE, SenderAge
from collplan_core.control.smallest_delay import STEP, SmallestDelay

LIMIT = 0.2
offsets = st.floats(-1e6, 1e6)


@given(offsets, st.lists(st.floats(0.0, 0.5), min_size=1, max_size=10))
def test_ages_are_counted_from_the_smallest_delay_whatever_the_sender_s_clock_says(offset, delays):
    age = SenderAge(LIMIT)
    assert math.isinf(age.measured(offset, 0.0))
    now = 0.0
    for k, delay in enumerate(delays):
        sent = 0.1 * (k + 1)
        now = max(now, sent + delay)  # messages come in order
        # the smallest delay may drift
        assert age.measured(offset + sent, now) == pytest.approx(now - sent, abs=2e-3)


@given(offsets, st.floats(1.5, 100.0), st.floats(0.5, 4.0))
def test_after_a_silence_another_sender_is_measured_anew(offset, silence, behind):
    age = SenderAge(LIMIT)
    age.measured(offset, 0.0)
    assert age.measured(offset + 0.1, 0.1) == pytest.approx(0.0, abs=1e-6)
    # the same one is known
    assert age.measured(offset + 5.1, 5.1) == pytest.approx(0.0, abs=1e-6)
    now = 5.0 + 0.1 + silence
    assert math.isinf(age.measured(offset + now - behind, now))
    assert age.measured(offset + now + 0.05 - behind, now + 0.05) == pytest.approx(0.0, abs=1e-6)


def test_what_is_late_within_a_stream_stays_late():
    age = SenderAge(LIMIT)
    age.measured(0.0, 0.0)
    for k in range(1, 6):
        now = 0.15 * k
        assert age.measured(now - 0.3, now) > LIMIT
    assert now < SILENCE


def test_a_step_of_the_senders_clock_spoils_one_message_at_most():
    for step in [-3600.0, 3600.0, -2 * STEP, 2 * STEP]:
        delay, late = SmallestDelay(), []
        for n in range(100):
            delay, age = delay.measured(0.05 * n + (step if n >= 50 else 0.0), 0.05 * n)
            late += [age] if age > 0.01 else []
        assert len(late) == (step < 0), step
