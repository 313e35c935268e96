"""Simulated time follows real time, and in lockstep waits for the graph."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.clock_steps import ClockOffset
from omnipuck_sim.node.lockstep import Lockstep
from omnipuck_sim.node.pacing import AT_ONCE, STALL, Pacing

PROPERTY = settings(derandomize=True, deadline=None, max_examples=30)
factors = st.sampled_from([0.05, 0.5, 1.0, 3.0])
CATCH_UP, RATE = 0.5, 400.0
LATE = {"controller_node": 0.01, "planner_node": 0.04}


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


@PROPERTY
@given(st.lists(st.tuples(st.floats(0.0, 0.2), st.floats(0.0, 0.1)), max_size=40), st.sampled_from([0.0, 1.0, 4.0]))
def test_simulated_time_never_passes_its_limit_and_reaches_it(steps, factor):
    pacing, now, time, limit = Pacing(RATE, factor, CATCH_UP, now=0.0), 0.0, 0.0, 0.0
    for passed, further in steps:
        now, limit = now + passed, limit + further
        time += pacing.due(now, limit - time) / RATE
        assert time <= limit + 1e-6
    for _ in range(500):
        now += 0.01
        time += pacing.due(now, limit - time) / RATE
    assert time > limit - 1 / RATE - 1e-6
    assert pacing.behind * RATE >= 1.0


def test_as_fast_as_the_graph_allows_is_real_time_where_nobody_is_waited_for():
    pacing = Pacing(RATE, 0.0, CATCH_UP, now=0.0)
    assert pacing.due(0.1) == 40
    assert pacing.due(0.1001, allowed=1.0) == round(AT_ONCE * RATE)


@PROPERTY
@given(st.dictionaries(st.sampled_from([*LATE, "mocap_node", "lidar_node"]), st.floats(0.0, 9.0)))
def test_the_limit_is_that_of_the_node_that_is_latest(until):
    lockstep = Lockstep(LATE, 0.03, patience=1.0)
    for node, time in until.items():
        assert not lockstep.report(node, time)
    assert lockstep.limit == min((time + LATE.get(node, 0.03) for node, time in until.items()), default=math.inf)
    for node in until:
        lockstep.report(node, math.inf)
    assert lockstep.limit == math.inf


def test_who_does_not_report_is_waited_for_no_longer_than_patience():
    lockstep = Lockstep(LATE, 0.03, patience=1.0)
    lockstep.report("controller_node", 5.0)
    lockstep.report("planner_node", 3.0)
    lockstep.report("lidar_node", 3.0)
    assert lockstep.waits(3.04, now=20.0) == []
    lockstep.goes_on()
    assert lockstep.waits(3.04, now=20.6) == []
    assert lockstep.waits(3.04, now=21.5) == []
    assert (lockstep.longest_wait, lockstep.longest_for) == (pytest.approx(0.9), "lidar_node")
    assert set(lockstep.waits(3.04, now=21.7)) == {"planner_node", "lidar_node"}
    assert lockstep.limit == 5.01
    assert lockstep.report("planner_node", 3.2)
    assert lockstep.limit == pytest.approx(3.24)


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
