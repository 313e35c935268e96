"""Restitution, friction, max_acceleration and lag from poses of rebounds and drives that are known."""

import os
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.calibration.drive_fit import DrivenStretches, fit_drive
from collplan_core.calibration.fitted_constant import TooLittle, Unexplained
from collplan_core.calibration.impact_fit import RecordedPath, UnusableImpact, fit_impact
from collplan_core.calibration.impact_search import find_impacts
from collplan_core.calibration.rebound_fit import fit_rebound
from collplan_core.calibration.wall_impacts import WallImpacts, seen_from_walls, sorted_out
from collplan_core.parameters import Robot, Settings
from collplan_core.velocity_law import velocity_after, velocity_law
from rebounding_paths import HIT, NOISE, ROBOT, rebounding_path, with_noise

shares = st.floats(0.0, 1.0)
into_wall, along_wall = st.floats(0.3, 1.0), st.floats(-0.8, 0.8)
angles = st.floats(-3.1, 3.1)
DEVIATION = 0.04


# ---- the velocities of one hit


@given(into_wall, along_wall, shares, shares, angles, st.floats(-0.02, 0.02))
def test_velocities_are_found_from_clean_poses(into, along, restitution, friction, angle, late):
    path, known = rebounding_path(into, along, restitution, friction, angle)
    hit = fit_impact(path, known.time + late, ROBOT, NOISE)
    assert hit.time == pytest.approx(known.time, abs=0.0015)
    np.testing.assert_allclose(hit.before, known.before, atol=0.002)
    np.testing.assert_allclose(hit.after, known.after, atol=0.002)
    assert abs(hit.position @ known.normal) < 0.0015


def test_poses_lost_at_the_hit_are_said():
    path, known = rebounding_path(0.6, 0.4, 0.6, 0.8)
    kept = (path.times < known.time + 0.02) | (path.times > known.time + 0.06)
    lost = RecordedPath(path.times[kept], path.points[kept], path.wanted[kept])
    # what was commanded meanwhile is lost as well
    assert fit_impact(lost, known.time, ROBOT, NOISE).after == pytest.approx(known.after, abs=0.03)
    few = RecordedPath(*(a[path.times < known.time + 0.05] for a in (path.times, path.points, path.wanted)))
    with pytest.raises(UnusableImpact, match="too few"):
        fit_impact(few, known.time, ROBOT, NOISE)
    path, known = rebounding_path(0.9, 0.0, 0.9, 1.0)
    since = np.maximum(path.times - known.time - 0.07, 0.0)[:, np.newaxis]
    with pytest.raises(UnusableImpact, match="one impact"):
        fit_impact(replace(path, points=path.points - 1.2 * since * known.normal), known.time, ROBOT, NOISE)


def test_hits_are_found_again_in_the_poses():
    random, found = np.random.default_rng(5), []
    quiet = Settings().with_values({"mocap.detect_impacts": False})
    for _ in range(5):
        path, known = rebounding_path(random.uniform(0.6, 1.0), random.uniform(-0.5, 0.5), 0.7, 0.8)
        hits = find_impacts(path.times, with_noise(path, random).points, quiet)
        assert len(hits) == 1
        found.append(hits[0] - known.time)
    assert np.abs(found).max() < 0.02


def test_spin_counts_where_the_ring_touches():
    path, known = rebounding_path(0.6, 0.0, 0.6, 0.2)
    hit = fit_impact(path, known.time, ROBOT, NOISE)
    still, turning = (seen_from_walls([hit], known.normal, [0.0], [spin], 0.1) for spin in (0.0, 3.0))
    assert turning.slip - still.slip == pytest.approx(0.3)


# ---- the constants

E, MU = 0.6, 0.15
K = ROBOT.inertia_factor


def measured(restitution, friction, n, random):
    hits, normals, depths = [], [], []
    for _ in range(n):
        sideways = random.uniform(0.3, 0.9) * random.choice([-1.0, 1.0])
        into_wall, angle = random.uniform(0.3, 1.0), random.uniform(-np.pi, np.pi)
        path, known = rebounding_path(into_wall, sideways, restitution, friction, angle, HIT + 0.2)
        hits.append(fit_impact(with_noise(path, random), known.time, ROBOT, NOISE))
        normals.append(known.normal)
        depths.append(-hits[-1].position @ known.normal)
    return seen_from_walls(hits, np.array(normals), depths, np.zeros(n), ROBOT.radius)


def test_the_constants_are_found_from_noisy_poses():
    for restitution, friction in [(0.85, 0.05), (0.4, 0.2)]:
        usable, _ = sorted_out(measured(restitution, friction, 24, np.random.default_rng(1)))
        fit = fit_rebound(usable, K)
        for estimate, truth in ((fit.restitution, restitution), (fit.friction, friction)):
            assert estimate.value == pytest.approx(truth, abs=0.05), (restitution, friction)
            assert estimate.holds(truth), (restitution, friction)
            assert estimate.high - estimate.low < 0.12, (restitution, friction)
        assert fit.warning == "", (restitution, friction)


def drawn(n, random, restitution=E, friction=MU, into=(0.26, 1.0), along=(0.5, 1.0), noise=0.02, drift=0.0):
    into_wall, slip = random.uniform(*into, n), random.uniform(*along, n) * random.choice([-1.0, 1.0], n)
    stopped = np.sign(slip) * np.minimum(friction * (1.0 + restitution) * into_wall, K * np.abs(slip))
    before = np.stack([into_wall, slip], axis=1) + random.normal(0.0, noise, (n, 2))
    after = np.stack([restitution * into_wall, slip - stopped], axis=1) + random.normal(0.0, noise, (n, 2))
    beyond = drift * into_wall[:, np.newaxis] * [0.5, -0.5] + random.normal(0.0, 2.0 * noise, (n, 2))
    return WallImpacts(before, after, before[:, 1], np.zeros((n, 2)), np.zeros(n), beyond, np.full((n, 2), DEVIATION))


@given(shares, st.floats(0.02, 0.15), st.integers(20, 40), st.integers(0, 999))
def test_without_noise_the_constants_are_exact(restitution, friction, n, seed):
    fit = fit_rebound(drawn(n, np.random.default_rng(seed), restitution, friction, into=(0.3, 0.6), noise=0.0), K)
    assert fit.restitution.value == pytest.approx(restitution, abs=1e-9)
    assert fit.friction.value == pytest.approx(friction, abs=1e-9)


def together(*hits):
    return WallImpacts(*(np.concatenate([getattr(h, f.name) for h in hits]) for f in fields(WallImpacts)))


def test_a_restitution_that_changes_after_the_hits_is_told():
    for drift, cause in [(0.2, "inertia"), (-0.2, "soft")]:
        fit = fit_rebound(drawn(40, np.random.default_rng(0), drift=drift), K)
        assert cause in fit.warning, (drift, cause)
        assert "20 to 60 ms" in fit.warning, (drift, cause)


def test_what_is_missing_is_said():
    for hits, said in (
        ({"n": 20, "into": (3.0, 4.0), "noise": 0.0}, r"slides.* of 20 .*0\.\d+.*grazing"),  # they stick
        ({"n": 7}, "restitution: 7 .*8"),
        ({"n": 20, "along": (0.0, 0.1)}, r"^friction: 0 .*0\.3 m/s.*grazing"),
        ({"n": 20, "into": (0.5, 0.55), "noise": 0.005}, r"^restitution: .*0\.2:.*slowly"),
        ({"n": 8, "into": (0.7, 1.0), "noise": 0.2}, "restitution: .*interval.*0.3"),
        ({"n": 20, "restitution": 1.4}, r"^restitution: 1\.\d+.*0 to 1"),
    ):
        with pytest.raises(TooLittle, match=said):
            fit_rebound(drawn(**hits, random=np.random.default_rng(0)), K)


def test_false_hits_are_sorted_out_and_counted():
    """One that gains speed, one sped up along the wall, one off a soft thing, two too slow."""
    good = drawn(20, np.random.default_rng(4))
    before = np.array([[0.5, 0.5], [0.5, 0.6], [0.9, 0.5], [0.1, 0.5], [-0.5, 0.0]])
    after = np.array([[0.8, 0.4], [0.3, 0.9], [0.0, 0.4], [0.06, 0.4], [0.3, 0.0]])
    nothing = np.zeros((5, 2))
    bad = WallImpacts(before, after, before[:, 1], nothing, np.zeros(5), nothing, np.full((5, 2), DEVIATION))
    hits = together(good, bad)
    usable, left_out = sorted_out(hits)
    assert len(usable) == 20
    assert sorted(left_out.values()) == [1, 2, 2]
    assert fit_rebound(usable, K) == fit_rebound(good, K)


@given(shares, st.floats(0.0, 0.02), st.floats(-0.01, 0.01), st.integers(0, 999))
def test_without_noise_touch_and_release_are_exact_wherever_the_wall_is(restitution, half, offset, seed):
    random = np.random.default_rng(seed)
    hits = drawn(20, random, restitution, 0.05, noise=0.0)
    driven, depths = random.uniform(-2.0, 2.0, (20, 2)), half * hits.before[:, 0] + offset
    out = restitution * (hits.before[:, 0] - half * driven[:, 0]) + half * driven[:, 1]
    pressed = replace(hits, after=np.stack([out, hits.after[:, 1]], axis=1), driven=driven, depths=depths)
    assert fit_rebound(pressed, K).restitution.value == pytest.approx(restitution, abs=1e-9)


PERIOD = 0.05
COMPILED = os.environ.get("NUMBA_DISABLE_JIT", "0") == "0"
compiled = pytest.mark.skipif(not COMPILED, reason="takes minutes without the compiler")


def driven(acceleration, lag, seed, duration=30.0, error=0.06, bias=0.03, leap=1.0):
    """Poses of a robot whose command leaps within +- `leap` [m/s] every half second, in stretches of three seconds."""
    random, law = np.random.default_rng(seed), velocity_law(Robot(max_acceleration=acceleration, velocity_lag=lag))
    times = 0.01 * np.arange(round(100 * duration))
    wanted = np.repeat(random.uniform(-leap, leap, (len(times) // 50 + 1, 2)), 50, axis=0)[: len(times)]
    errors = np.repeat(random.normal(0.0, error, (len(times) // 5 + 1, 2)), 5, axis=0)[: len(times)]
    aimed = wanted + errors + random.normal(0.0, bias, 2)
    position, velocity, points = np.zeros(2), np.zeros(2), []
    for aim in aimed:
        points.append(position)
        for _ in range(10):
            before = velocity
            velocity = np.array(velocity_after(law, *velocity, *aim, 0.001))
            position = position + 0.0005 * (before + velocity)
    measured = np.array(points) + random.normal(0.0, NOISE, (len(times), 2))
    ends = np.arange(0, len(times) + 1, 300)
    return DrivenStretches(
        f"run {seed}", times, measured, wanted, np.stack([ends[:-1], ends[1:]], axis=1), PERIOD, NOISE
    )


@compiled
def test_the_drive_is_found():
    for acceleration, lag in ((1.5, 0.1), (3.0, 0.05)):
        fit = fit_drive([driven(acceleration, lag, seed) for seed in (0, 1)])
        assert fit.max_acceleration.value == pytest.approx(acceleration, rel=0.02)
        assert fit.velocity_lag.value == pytest.approx(lag, abs=0.03)
        assert fit.wheel_error == pytest.approx(0.06, rel=0.4)
        for constant in (fit.max_acceleration, fit.velocity_lag):
            assert constant.low < constant.value < constant.high


@compiled
def test_the_bias_of_each_run_is_found():
    biased = driven(1.5, 0.1, 3, bias=0.0)
    shifted = biased.wanted - [0.1, -0.05]
    run = DrivenStretches("run", biased.times, biased.points, shifted, biased.stretches, PERIOD, NOISE)
    assert fit_drive([run]).biases[0] == pytest.approx((0.1, -0.05), abs=0.03)


@compiled
def test_too_little_driving_and_what_is_no_such_drive_are_refused():
    run = driven(1.5, 0.1, 0)
    other = DrivenStretches("run", run.times, run.points, run.wanted[:, ::-1].copy(), run.stretches, PERIOD, NOISE)
    table = [
        ([driven(1.5, 0.1, 0, duration=9.0)], TooLittle, "10 s"),
        ([driven(3.0, 0.2, 0, leap=0.1)], TooLittle, "changes"),
        ([other], Unexplained, "drive law"),
        ([run, driven(1.5, 0.1, 1), driven(0.9, 0.1, 2)], Unexplained, "."),
    ]
    for runs, error, words in table:
        with pytest.raises(error, match=words):
            fit_drive(runs)
