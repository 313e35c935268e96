"""The drive, its watchdog, noise and seeds; where the robot may start."""

from dataclasses import replace

import numpy as np
import pytest

from collplan_core.evaluation.run_end import ACTUATION_BIAS, ACTUATION_NOISE
from collplan_core.parameters import Limits, Settings, Simulation
from collplan_core.worlds import WorldError
from omnipuck_sim.robot.noise import Noise
from omnipuck_sim.robot.physics import Simulator
from physics_scenes import QUIET, make_world, unit

OPEN = make_world(start=np.zeros(2))
LAG, A_MAX = QUIET.robot.velocity_lag, QUIET.robot.max_acceleration
RATE = QUIET.simulator.physics_rate
PERIOD = round(RATE / QUIET.controller.rate)
"""Steps between two commands."""


def drive(sim: Simulator, velocity, yaw_rate: float, duration: float) -> np.ndarray:
    """Commands at 20 Hz; velocities (n, 2) after each step."""
    end, velocities = sim.time + duration - 1e-9, []
    while sim.time < end:
        if len(velocities) % PERIOD == 0:
            sim.command(np.asarray(velocity), yaw_rate)
        sim.step()
        velocities.append(sim.state.velocity)
    return np.array(velocities)


def noisy(**simulation) -> Settings:
    return Settings(simulator=Simulation(**simulation))


def test_small_changes_follow_a_first_order_lag_and_large_ones_take_the_largest_acceleration():
    speed = 0.9 * A_MAX * LAG
    velocities = drive(Simulator(OPEN, QUIET, 0), (speed, 0.0), 0.0, 0.5)
    times = np.arange(1, len(velocities) + 1) / RATE
    assert velocities[:, 0] == pytest.approx(speed * (1 - np.exp(-times / LAG)), abs=1e-9)
    assert not velocities[:, 1].any()

    velocities = drive(Simulator(OPEN, QUIET, 0), 1.2 * unit(0.6), 0.0, 0.6)
    assert velocities[: len(times)] == pytest.approx(A_MAX * times[:, None] * unit(0.6))
    assert np.linalg.norm(np.diff(velocities, axis=0), axis=1).max() <= A_MAX / RATE + 1e-12

    without_lag = replace(QUIET, robot=replace(QUIET.robot, velocity_lag=0.0))
    velocities = drive(Simulator(OPEN, without_lag, 0), (1.2, 0.0), 0.0, 1.0)
    assert np.diff(velocities[:, 0]).max() <= A_MAX / RATE + 1e-12
    assert velocities[-1] == pytest.approx([1.2, 0.0])


def test_the_yaw_rate_lags_like_the_velocity_and_the_yaw_wraps():
    sim = Simulator(OPEN, QUIET, 0)
    drive(sim, (0.0, 0.0), 1.9, 2.2)
    assert sim.spin == pytest.approx(1.9, abs=1e-6)
    # at a lag of 0.1 s it comes 0.19 rad later than without one
    assert sim.state.yaw == pytest.approx(1.9 * 2.2 - 0.19 - 2 * np.pi, abs=2e-3)
    assert not sim.state.velocity.any()


def test_silence_zeroes_the_command_after_its_age_and_one_period():
    for age in (0.05, 0.2, 0.5):
        sim = Simulator(OPEN, replace(QUIET, limits=Limits(command_age=age)), 0)
        drive(sim, (1.0, 0.0), 0.0, 2.0)
        while sim.time < 1.95 + age + 0.05 - 1e-9:  # the last command left at 1.95
            sim.step()
        speed = sim.state.velocity[0]
        assert speed == pytest.approx(1.0, abs=1e-3), age
        sim.step()
        assert sim.state.velocity[0] == pytest.approx(speed - A_MAX / RATE), age
        for _ in range(2 * round(RATE)):
            sim.step()
        assert sim.state.velocity == pytest.approx([0.0, 0.0], abs=1e-3)
    sim = Simulator(OPEN, QUIET, 0)
    sim.command(np.zeros(2), 0.4)
    for _ in range(round(RATE)):
        sim.step()
    assert sim.spin == pytest.approx(0.0, abs=1e-3)
    assert sim.state.yaw == pytest.approx(0.4 * 0.25, abs=2e-3)


def test_actuation_noise_has_its_level_and_the_bias_is_constant_in_a_run_and_differs_between_runs():
    runs = [Noise(Simulation(), seed) for seed in range(60)]
    errors = np.array([[run.actuation() for _ in range(2000)] for run in runs])
    assert errors.std(axis=1) == pytest.approx(np.full((60, 2), ACTUATION_NOISE), rel=0.1)
    assert errors.mean(axis=1).std() == pytest.approx(ACTUATION_BIAS, rel=0.25)


def test_measured_poses_scatter_about_the_truth():
    sim = Simulator(OPEN, noisy(), 0)
    samples = np.array([sim.measured_pose().position for _ in range(2000)]) - sim.state.position
    assert samples.mean(axis=0) == pytest.approx([0.0, 0.0], abs=2e-4)
    assert samples.std(axis=0) == pytest.approx([0.002, 0.002], rel=0.1)
    sim.place(np.zeros(2), yaw=0.3)
    assert sim.measured_pose().yaw == sim.state.yaw
    for offset in (0.0, 3.1):
        sim = Simulator(OPEN, noisy(mocap_yaw_noise=0.05, marker_offset_yaw=offset), 0)
        yaws = np.array([sim.measured_pose().yaw for _ in range(4000)])
        assert (abs(yaws) <= np.pi).all()
        errors = (yaws - sim.state.yaw - offset + np.pi) % (2 * np.pi) - np.pi
        # four standard errors
        assert errors.mean() == pytest.approx(0.0, abs=4 * 0.05 / np.sqrt(4000))
        assert errors.std() == pytest.approx(0.05, rel=4 / np.sqrt(8000))


def test_a_tilted_floor_is_a_plane_in_the_axes_and_seen_from_above():
    sim = Simulator(OPEN, noisy(noise=0.0, floor_tilt=(0.05, -0.02)), 0)
    rows = []
    for x, y, yaw in ((0.0, 0.0, 0.3), (1.0, 0.0, 2.0), (0.0, 1.0, -1.0), (0.7, 1.1, 0.0)):
        sim.place(np.array([x, y]), yaw=yaw)
        pose = sim.measured_pose()
        rows.append((x, y, *pose.position, pose.height, pose.yaw - yaw, pose.tilt))
    x, y, seen_x, seen_y, height, turned, tilt = np.array(rows).T
    np.testing.assert_allclose(np.hypot(np.hypot(seen_x, seen_y), height), np.hypot(x, y), atol=1e-12)
    np.testing.assert_allclose(height, np.tan(0.05) * seen_x - np.tan(0.02) * seen_y, atol=1e-12)
    assert abs(turned).max() < 0.002
    np.testing.assert_allclose(np.tan(tilt), np.hypot(np.tan(0.05), np.tan(0.02)))


def test_strategies_meet_the_same_noise():
    """Whatever is measured or commanded before, the errors at one time are the same."""
    a, b = (Simulator(OPEN, noisy(), 5) for _ in range(2))
    drive(a, (0.0, 0.0), 0.0, 1.0)
    drive(b, (0.3, 0.3), 0.0, 1.0)
    for _ in range(50):
        b.measured_pose()
    b.place(np.zeros(2))
    assert (drive(a, (0.5, 0.0), 0.0, 0.5) == drive(b, (0.5, 0.0), 0.0, 0.5)).all()


def test_a_start_that_is_not_free_is_an_error():
    pole = make_world(circles=[(0.0, 0.0, 0.2)])
    room = make_world(walled=True, bounds=(0.0, 0.0, 2.0, 2.0))
    cases = [(pole, (0.25, 0.0), r"0\.04 m inside"), (make_world(), None, "none")]
    cases += [(room, start, "start") for start in ((0.05, 1.0), (3.0, 1.0), (np.nan, 1.0))]
    for world, start, why in cases:
        with pytest.raises(WorldError, match=why):
            Simulator(world, QUIET, 0, start=None if start is None else np.array(start))


@pytest.mark.parametrize("engine", ["pymunk", "mujoco"])
@pytest.mark.parametrize("far", [0.0, 5e6])
def test_a_robot_that_touches_a_wall_starts_and_drives_off(engine, far):
    room = make_world(walled=True, bounds=(far, far, far + 2.0, far + 2.0))
    sim = Simulator(room, QUIET.with_values({"simulator.engine": engine}), 0, start=np.array([far + 0.09, far + 1.0]))
    drive(sim, (0.5, 0.0), 0.0, 1.0)
    assert sim.state.position[0] > far + 0.3
    assert not sim.take_impacts()
