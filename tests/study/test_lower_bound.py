"""The lower bound: by hand, and below the time of every motion that keeps the limits."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_study.optimum.disc import Disc
from collplan_study.optimum.free_chain import FreeChain, Region
from collplan_study.optimum.lower_bound import lower_bound, rest_to_free, rest_to_rest, turning_points

SPEED, ACCELERATION = 1.2, 1.5
DISC = Disc(0.09, SPEED, ACCELERATION, 0.1)


def chain_of(*boxes: tuple[float, float, float, float], start: tuple, goal: tuple) -> FreeChain:
    """A chain whose boxes are given, x0, y0, x1, y1; the bound asks nothing of the corners."""
    regions = tuple(Region(np.array(box[:2]), np.array(box[2:])) for box in boxes)
    return FreeChain(regions, np.array(start), np.array(goal))


def test_rest_to_rest_and_rest_to_free_by_hand():
    to_rest = [
        (0.0, 0.0),
        (0.24, 0.8),  # 0.12 m in 0.4 s up to 0.6 m/s, and back to rest
        (0.96, 1.6),  # just up to full speed
        (2.16, 2.6),  # 1.2 m more at full speed
    ]
    for distance, time in to_rest:
        assert rest_to_rest(distance, SPEED, ACCELERATION) == pytest.approx(time), distance
    for distance, time in [(0.0, 0.0), (0.12, 0.4), (0.48, 0.8), (1.68, 1.8)]:
        assert rest_to_free(distance, SPEED, ACCELERATION) == pytest.approx(time), distance


def test_turning_points_by_hand():
    for visits, points in [
        ([], [0.0, 0.0]),
        ([(-1.0, 1.0), (-2.0, 0.5)], [0.0, 0.0]),
        ([(1.0, 2.0), (3.0, 4.0), (2.0, 5.0)], [0.0, 3.0]),
        ([(1.0, 2.0), (-5.0, 0.5), (0.0, 3.0)], [0.0, 1.0, 0.5]),
        ([(-3.0, -1.0), (0.0, 2.0), (1.0, 2.0), (-9.0, -2.0)], [0.0, -1.0, 1.0, -2.0]),
    ]:
        assert turning_points(0.0, visits) == points, visits


def test_a_u_takes_the_way_over_its_tip_and_back():
    chain = chain_of(
        (0.0, 0.0, 1.0, 0.2), (0.9, 0.0, 1.0, 0.6), (0.0, 0.4, 1.0, 0.6), start=(0.0, 0.1), goal=(0.0, 0.5)
    )
    # 0.9 m to the tip, from rest to rest; 0.8 m back to the goal, the last 0.32 m at full speed
    assert lower_bound(chain, DISC) == pytest.approx(2 * math.sqrt(0.9 / 1.5) + 0.8 + 0.32 / 1.2)


def test_where_nothing_turns_back_it_is_the_longer_way_of_both_axes():
    chain = chain_of((0.0, 0.0, 3.0, 0.2), (2.8, 0.0, 3.0, 2.0), start=(0.1, 0.1), goal=(2.9, 1.9))
    assert lower_bound(chain, DISC) == pytest.approx(0.8 + (2.7 - 0.48) / 1.2)


@st.composite
def motions(draw) -> tuple[float, np.ndarray]:
    """Duration and positions (n,) of a motion along a line that begins at rest and keeps the limits."""
    velocities = np.array([0.0, *draw(st.lists(st.floats(-SPEED, SPEED), min_size=1, max_size=8))])
    coasting = draw(st.lists(st.floats(0.0, 1.0), min_size=len(velocities) - 1, max_size=len(velocities) - 1))
    # at one acceleration from each velocity to the next, at most the largest
    steps = np.abs(np.diff(velocities)) / ACCELERATION + coasting
    ways = (velocities[1:] + velocities[:-1]) / 2 * steps
    return float(steps.sum()), np.cumsum(ways)


@given(motion=motions(), margins=st.lists(st.tuples(st.floats(0.0, 0.5), st.floats(0.0, 0.5)), min_size=8, max_size=8))
@settings(derandomize=True, deadline=None, max_examples=50)
def test_no_motion_beats_it(motion, margins):
    duration, positions = motion
    visits = [(x - below, x + above) for x, (below, above) in zip(positions, margins, strict=False)]
    chain = chain_of(*((low, 0.0, high, 1.0) for low, high in visits), start=(0.0, 0.5), goal=(positions[-1], 0.5))
    assert lower_bound(chain, DISC) <= duration + 1e-9


@given(a=st.floats(0.0, 5.0), b=st.floats(0.0, 5.0))
@settings(derandomize=True, deadline=None, max_examples=50)
def test_stopping_on_the_way_never_helps(a, b):
    limits = SPEED, ACCELERATION
    assert rest_to_rest(a + b, *limits) <= rest_to_rest(a, *limits) + rest_to_rest(b, *limits) + 1e-9
    assert rest_to_free(a, *limits) <= rest_to_rest(a, *limits) <= 2 * rest_to_free(a, *limits) + 1e-9
