"""Simulated time follows real time."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.clock_steps import ClockOffset
from omnipuck_sim.node.pacing import STALL, Pacing, RealTimeFactor

PROPERTY = settings(derandomize=True, deadline=None, max_examples=30)
factors = st.sampled_from([0.05, 0.5, 1.0, 3.0])
CATCH_UP, RATE = 0.5, 400.0


@PROPERTY
@given(st.lists(st.floats(0.0, 0.016), max_size=60), factors, st.sampled_from([240.0, 400.0, 1000.0]))
def test_without_stalls_no_time_is_lost(waits, factor, rate):
    pacing, now, steps = Pacing(rate, factor, CATCH_UP, now=100.0), 100.0, 0
    for wait in waits:
        now += wait
        steps += pacing.due(now)
        assert -1e-6 <= pacing.behind <= 1 / rate
        assert steps / rate + pacing.behind == pytest.approx((now - 100.0) * factor, abs=1e-9)
    assert (pacing.given_up, pacing.stalled) == (0.0, 0.0)


def test_after_a_stall_no_more_is_made_up_for_than_may_be_and_a_clock_set_back_takes_no_step():
    for stall in (0.06, 0.4, 1e4):
        pacing = Pacing(RATE, 1.0, CATCH_UP, now=0.0)
        assert pacing.due(stall) == round(min(stall, CATCH_UP) * RATE), stall
        assert pacing.given_up == pytest.approx(max(stall - CATCH_UP, 0.0))
        assert pacing.stalled == pytest.approx(stall - STALL)
        assert pacing.due(stall + 0.011) == 4
    pacing = Pacing(RATE, 1.0, CATCH_UP, now=10.0)
    assert pacing.due(5.0) == 0
    assert pacing.due(5.011) == 4


def test_the_real_time_factor_leaves_out_while_time_stands_still():
    factor = RealTimeFactor(0.0, now=10.0)
    assert factor.measured(0.0, 30.0) == 1.0
    assert factor.measured(1.5, 31.0) == 1.5
    assert factor.measured(1.6, 31.1) == 1.5
    assert factor.measured(2.0, 32.0) == 0.5


@PROPERTY
@given(st.lists(st.floats(0.0, 0.3), min_size=3, max_size=60), st.floats(-1e9, 1e9))
def test_a_stall_between_two_readings_of_the_clocks_changes_nothing(stalls, ahead):
    time, left = 0.0, stalls

    def steady():
        nonlocal time, left
        time, left = time + (left[0] if left else 0.0), left[1:]
        return time

    offset = ClockOffset(lambda: steady() + ahead, steady)
    for _ in stalls:
        assert not offset.compare()
        assert offset.ahead == pytest.approx(ahead, abs=1.5e-3)


def test_a_clock_that_was_set_is_noticed():
    times = {"steady": 5.0, "wall": 100.0}
    offset = ClockOffset(lambda: times["wall"], lambda: times["steady"])
    times["wall"] += 3600.0
    assert offset.compare()
    assert offset.ahead == pytest.approx(3695.0)
    assert not offset.compare()
