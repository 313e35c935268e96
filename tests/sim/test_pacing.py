"""Simulated time follows real time, and gives up what a stall of the simulator would make it rush through."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnipuck_sim.node.pacing import LONGEST_CATCH_UP, Pacing

factors = st.sampled_from([0.05, 0.5, 1.0, 3.0])


@settings(derandomize=True, deadline=None, max_examples=60)
@given(st.lists(st.floats(0.0, 0.016), max_size=60), factors, st.sampled_from([240.0, 400.0, 1000.0]))
def test_without_stalls_no_time_is_lost(waits, factor, rate):
    pacing, now, steps = Pacing(rate, factor, now=100.0), 100.0, 0
    for wait in waits:
        now += wait
        steps += pacing.due(now)
        assert pacing.ahead >= -1e-9
        assert pacing.ahead <= 1 / rate + 1e-9
        assert steps / rate + pacing.ahead == pytest.approx((now - 100.0) * factor, abs=1e-9)
    assert pacing.lost == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("stall", [0.06, 1.0, 1e4])
def test_after_a_stall_at_most_50_ms_are_made_up_for(stall):
    pacing = Pacing(400.0, 1.0, now=0.0)
    assert pacing.due(stall) == round(LONGEST_CATCH_UP * 400.0)
    assert pacing.lost == pytest.approx(stall - LONGEST_CATCH_UP)
    assert pacing.due(stall + 0.011) == 4


def test_a_clock_that_steps_back_takes_no_step():
    pacing = Pacing(400.0, 1.0, now=10.0)
    assert pacing.due(5.0) == 0
    assert pacing.due(5.011) == 4
