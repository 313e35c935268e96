"""The pose at a scan's stamp."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.sensing.pose_history import PoseHistory
from collplan_core.state import State


def state(stamp, x=0.0, yaw=0.0):
    return State(stamp, np.array([x, -x]), np.array([1.0, x]), yaw)


def history(*states, span=0.5):
    kept = PoseHistory(span)
    for each in states:
        kept.add(each)
    return kept


def test_there_is_none_before_the_first_after_the_last_nor_once_cleared():
    assert PoseHistory(0.5).at(0.0) is None
    kept = history(state(1.0), state(1.1))
    assert [kept.at(stamp) is None for stamp in (0.999, 1.0, 1.1, 1.101)] == [True, False, False, True]
    kept.clear()
    assert kept.at(1.0) is None


@given(yaw=st.floats(-math.pi, math.pi), turn=st.floats(-3.0, 3.0), share=st.floats(0.0, 1.0))
def test_between_two_it_is_linear_and_yaw_goes_the_shortest_way(yaw, turn, share):
    ends = state(1.0, 2.0, yaw), state(1.5, -3.0, math.remainder(yaw + turn, math.tau))
    at, x = history(*ends).at(1.0 + 0.5 * share), 2.0 - 5.0 * share
    assert math.remainder(at.yaw - (yaw + share * turn), math.tau) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose([at.stamp, *at.position, *at.velocity], [1.0 + 0.5 * share, x, -x, 1.0, x], atol=1e-12)


def test_forgets_after_its_span():
    kept = history(*(state(0.1 * k) for k in range(20)), span=0.5)
    assert kept.at(1.39) is None
    assert kept.at(1.41) is not None


def test_clock_set_back_begins_anew():
    for stamp in [1.9, 1.0, -5.0]:
        kept = history(state(1.0), state(1.9), state(stamp))
        assert kept.at(stamp) is not None, stamp
        assert kept.at(1.45) is None, stamp
