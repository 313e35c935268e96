"""The rebound model: bounds, limits and symmetries."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.reflection import rebound
from scenes import rotation, unit

velocities = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)).map(np.array)
angles = st.floats(-np.pi, np.pi)
shares = st.floats(0.0, 1.0)
QUICK = settings(derandomize=True, deadline=None, max_examples=100, print_blob=True)


@QUICK
@given(v=velocities, normal=angles.map(unit), e=shares, k=shares)
def test_energy_never_grows_and_each_part_keeps_its_share(v, normal, e, k):
    after = rebound(v, normal, e, k)
    assert np.hypot(*after) <= np.hypot(*v) * (1 + 1e-12)
    tangent = rotation(np.pi / 2) @ normal
    assert after @ normal == pytest.approx(-e * (v @ normal), abs=1e-12)
    assert after @ tangent == pytest.approx(k * (v @ tangent), abs=1e-12)


@QUICK
@given(v=velocities, normal=angles.map(unit), e=shares, k=shares)
def test_the_sign_of_the_normal_is_irrelevant(v, normal, e, k):
    np.testing.assert_array_equal(rebound(v, normal, e, k), rebound(v, -normal, e, k))


@QUICK
@given(v=velocities, normal=angles.map(unit))
def test_a_perfect_rebound_is_a_mirror_and_its_own_inverse(v, normal):
    mirrored = v - 2 * (v @ normal) * normal
    np.testing.assert_allclose(rebound(v, normal, 1.0, 1.0), mirrored, atol=1e-12)
    np.testing.assert_allclose(rebound(rebound(v, normal, 1.0, 1.0), normal, 1.0, 1.0), v, atol=1e-12)


@QUICK
@given(v=velocities, normal=angles.map(unit), e=shares, k=shares, turn=angles, mirror=st.booleans())
def test_it_turns_and_mirrors_with_the_world(v, normal, e, k, turn, mirror):
    move = rotation(turn) @ np.diag([1.0, -1.0 if mirror else 1.0])
    np.testing.assert_allclose(rebound(move @ v, move @ normal, e, k), move @ rebound(v, normal, e, k), atol=1e-12)


@QUICK
@given(v=velocities, normal=angles.map(unit), e=shares, k=shares, scale=st.floats(0.0, 5.0))
def test_it_is_linear_in_the_velocity(v, normal, e, k, scale):
    np.testing.assert_allclose(rebound(scale * v, normal, e, k), scale * rebound(v, normal, e, k), atol=1e-11)


def test_by_hand_a_wall_met_at_45_degrees():
    np.testing.assert_allclose(rebound(np.array([1.0, -1.0]), np.array([0.0, 1.0]), 0.7, 0.8), [0.8, 0.7])
    np.testing.assert_allclose(rebound(np.array([0.0, -1.0]), np.array([0.0, 1.0]), 0.7, 0.8), [0.0, 0.7])
    np.testing.assert_allclose(rebound(np.array([1.0, 0.0]), np.array([0.0, 1.0]), 0.7, 0.8), [0.8, 0.0])
