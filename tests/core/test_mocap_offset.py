"""The body's place on the robot, from how the robot turns and goes."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.calibration.mocap_offset import body_offset, mean_pose
from collplan_core.calibration.stream_quality import stream_quality
from collplan_core.calibration.stroke_fit import AxesFit
from collplan_core.calibration.turn_fit import TurnFit
from collplan_core.sensing.mocap_body import with_offset
from collplan_core.sensing.pose_filter import PoseSample

short = st.floats(-0.2, 0.2)


@given(short, short, st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_the_offset_puts_the_body_where_it_is_seen(lever_x, lever_y, turn, heading):
    """A robot that goes along its own x, and about whose centre the body has this lever."""
    offset = body_offset(AxesFit(turn, 0.01, 1.0, False), TurnFit(np.array([lever_x, lever_y]), 1e-3, 1.0, 0.0))
    body = with_offset(PoseSample(0.0, np.zeros(2), heading), offset.x, offset.y, offset.yaw)
    lever = complex(lever_x, lever_y) * np.exp(1j * body.yaw)
    np.testing.assert_allclose(body.position, [lever.real, lever.imag], atol=1e-12)
    assert abs(math.remainder(body.yaw + turn - heading, math.tau)) < 1e-12


def test_mean_pose_across_the_back():
    mean = mean_pose([PoseSample(0.0, np.zeros(2), math.pi - 0.1), PoseSample(1.0, np.ones(2), -math.pi + 0.1)])
    assert abs(mean.yaw) == pytest.approx(math.pi)
    assert (mean.stamp, mean.position.tolist()) == (1.0, [0.5, 0.5])


def test_quality_of_a_stream():
    random = np.random.default_rng(3)
    stamps = 0.01 * np.arange(400)
    received = stamps + 7.0
    received[200:] += 0.05
    quality = stream_quality(stamps, received, random.normal(0.0, (0.001, 0.002), (400, 2)))
    assert quality.rate == pytest.approx(100.0)
    assert quality.longest_gap == pytest.approx(0.06)
    assert quality.jitter < 0.001
    assert quality.noise == pytest.approx(0.002, rel=0.1)
