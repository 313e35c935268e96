"""The drive, its watchdog, noise and seeds; where the robot may start."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from collplan_core.parameters import Limits, Settings, Simulation
from collplan_core.worlds import WorldError
from omnipuck_sim.robot.physics import Simulator
from physics_scenes import QUIET, RADIUS, make_world, quiet, unit

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


def test_small_changes_follow_a_first_order_lag():
    speed = 0.9 * A_MAX * LAG
    velocities = drive(Simulator(OPEN, QUIET, 0), (speed, 0.0), 0.0, 0.5)
    times = np.arange(1, len(velocities) + 1) / RATE
    assert velocities[:, 0] == pytest.approx(speed * (1 - np.exp(-times / LAG)), abs=1e-9)
    assert not velocities[:, 1].any()


def test_large_changes_take_the_largest_acceleration_in_a_straight_line():
    velocities = drive(Simulator(OPEN, QUIET, 0), 1.2 * unit(0.6), 0.0, 0.6)
    times = np.arange(1, round(0.5 * RATE) + 1) / RATE
    assert velocities[: len(times)] == pytest.approx(A_MAX * times[:, None] * unit(0.6))
    speeds = np.linalg.norm(np.diff(velocities, axis=0), axis=1)
    assert speeds.max() <= A_MAX / RATE + 1e-12


def test_without_lag_it_still_keeps_the_largest_acceleration():
    config = replace(QUIET, robot=replace(QUIET.robot, velocity_lag=0.0))
    velocities = drive(Simulator(OPEN, config, 0), (1.2, 0.0), 0.0, 1.0)
    assert np.diff(velocities[:, 0]).max() <= A_MAX / RATE + 1e-12
    assert velocities[-1] == pytest.approx([1.2, 0.0])


def test_commands_are_in_the_frame_of_the_body():
    sim = Simulator(OPEN, QUIET, 0)
    sim.place(np.zeros(2), yaw=np.pi / 2)
    assert drive(sim, (0.5, 0.0), 0.0, 1.0)[-1] == pytest.approx([0.0, 0.5], abs=1e-4)


def test_the_yaw_rate_lags_like_the_velocity_and_the_yaw_wraps():
    sim = Simulator(OPEN, QUIET, 0)
    drive(sim, (0.0, 0.0), 1.9, 2.2)
    assert sim.spin == pytest.approx(1.9, abs=1e-6)
    # at a lag of 0.1 s it comes 0.19 rad later than without one
    assert sim.state.yaw == pytest.approx(1.9 * 2.2 - 0.19 - 2 * np.pi, abs=2e-3)
    assert not sim.state.velocity.any()


def test_a_hit_at_an_angle_turns_the_body():
    wall = [(0.3, -1.0), (0.5, -1.0), (0.5, 1.0), (0.3, 1.0)]
    sim = Simulator(make_world([wall]), QUIET, 0, start=np.zeros(2))
    while not sim.take_impacts():
        sim.command(1.0 * unit(0.5), 0.0)
        sim.step()
    # the wall holds the side that it touches back: counter-clockwise for one on the right hand of the motion
    assert sim.spin < -0.5


@pytest.mark.parametrize("age", [0.05, 0.2, 0.5])
def test_silence_zeroes_the_command_after_its_age_and_one_period(age):
    sim = Simulator(OPEN, replace(QUIET, limits=Limits(command_age=age)), 0)
    drive(sim, (1.0, 0.0), 0.0, 2.0)
    while sim.time < 1.95 + age + 0.05 - 1e-9:  # the last command left at 1.95
        sim.step()
    assert sim.state.velocity[0] == pytest.approx(1.0, abs=1e-3)
    speed = sim.state.velocity[0]
    sim.step()
    assert sim.state.velocity[0] == pytest.approx(speed - A_MAX / RATE)
    for _ in range(2 * round(RATE)):
        sim.step()
    assert sim.state.velocity == pytest.approx([0.0, 0.0], abs=1e-3)


def test_silence_ends_the_turning_too():
    sim = Simulator(OPEN, QUIET, 0)
    sim.command(np.zeros(2), 0.4)
    for _ in range(round(RATE)):
        sim.step()
    assert sim.spin == pytest.approx(0.0, abs=1e-3)
    assert sim.state.yaw == pytest.approx(0.4 * 0.25, abs=2e-3)


@pytest.mark.parametrize("bad", [(np.nan, 0.0, 0.0), (0.0, np.inf, 0.0), (0.0, 0.0, -np.inf)])
def test_a_command_that_is_no_number_is_refused(bad):
    sim = Simulator(OPEN, QUIET, 0)
    with pytest.raises(ValueError, match="expected finite"):
        sim.command(np.array(bad[:2]), bad[2])
    sim.step()
    assert not sim.state.velocity.any()


def test_time_is_an_exact_multiple_of_the_step():
    sim = Simulator(OPEN, quiet(physics_rate=600.0), 0)
    for k in range(1000):
        assert sim.time == k / 600.0
        sim.step()


def noisy(**simulation) -> Settings:
    return Settings(simulator=Simulation(**simulation))


def test_a_robot_told_to_stand_still_stands_still_in_spite_of_noise():
    sim = Simulator(OPEN, noisy(noise=5.0), 3)
    start = sim.state.position
    drive(sim, (0.0, 0.0), 0.0, 1.0)
    assert (sim.state.position == start).all()


def test_actuation_noise_has_the_level_asked_for():
    config = replace(noisy(actuation_bias=0.0), robot=replace(QUIET.robot, velocity_lag=0.0, max_acceleration=20.0))
    velocities = drive(Simulator(OPEN, config, 1), (0.5, -0.3), 0.0, 60.0)[19::20]
    assert velocities.mean(axis=0) == pytest.approx([0.5, -0.3], abs=0.01)
    assert velocities.std(axis=0) == pytest.approx([0.06, 0.06], rel=0.1)


def test_bias_is_constant_in_a_run_and_differs_between_runs():
    config = noisy(actuation_noise=0.0, start_noise=0.0)
    biases = [drive(Simulator(OPEN, config, seed), (0.5, 0.0), 0.0, 2.0)[-1] - [0.5, 0.0] for seed in range(60)]
    assert np.std(biases) == pytest.approx(0.03, rel=0.25)
    sim = Simulator(OPEN, config, 7)
    steady = drive(sim, (0.5, 0.0), 0.0, 3.0)[800:]
    assert np.ptp(steady, axis=0) == pytest.approx([0.0, 0.0], abs=1e-3)


def test_measured_poses_scatter_about_the_truth():
    sim = Simulator(OPEN, noisy(), 0)
    samples = np.array([sim.measured_pose().position for _ in range(2000)]) - sim.state.position
    assert samples.mean(axis=0) == pytest.approx([0.0, 0.0], abs=2e-4)
    assert samples.std(axis=0) == pytest.approx([0.002, 0.002], rel=0.1)


@pytest.mark.parametrize("offset", [0.0, 3.1])
def test_measured_yaws_scatter_about_the_truth(offset):
    sim = Simulator(OPEN, noisy(mocap_yaw_noise=0.05, marker_offset_yaw=offset), 0)
    yaws = np.array([sim.measured_pose().yaw for _ in range(4000)])
    assert (abs(yaws) <= np.pi).all()
    errors = (yaws - sim.state.yaw - offset + np.pi) % (2 * np.pi) - np.pi
    # four standard errors
    assert errors.mean() == pytest.approx(0.0, abs=4 * 0.05 / np.sqrt(4000))
    assert errors.std() == pytest.approx(0.05, rel=4 / np.sqrt(8000))


def test_without_yaw_noise_the_yaw_is_the_true_one_to_the_bit():
    sim = Simulator(OPEN, noisy(), 0)
    sim.place(np.zeros(2), yaw=0.3)
    assert sim.measured_pose().yaw == sim.state.yaw


def test_strategies_meet_the_same_noise():
    """Whatever is measured or commanded before, the errors at one time are the same."""
    a, b = (Simulator(OPEN, noisy(start_noise=0.0), 5) for _ in range(2))
    drive(a, (0.0, 0.0), 0.0, 1.0)
    drive(b, (0.3, 0.3), 0.0, 1.0)
    for _ in range(50):
        b.measured_pose()
    b.place(np.zeros(2))
    assert (drive(a, (0.5, 0.0), 0.0, 0.5) == drive(b, (0.5, 0.0), 0.0, 0.5)).all()


STORY = """
import numpy as np
from collplan_core.parameters import Settings, Simulation
from collplan_core.worlds import World
from omnipuck_sim.robot.physics import Simulator
triangle, circle = np.array([[1.0, 1.0], [1.4, 1.1], [1.2, 1.5]]), np.array([[0.4, 1.4, 0.1]])
world = World("box", (triangle,), circle, (0.0, 0.0, 2.0, 2.0), walled=True, start=np.array([0.5, 0.5]))
sim = Simulator(world, Settings(simulator=Simulation(restitution_spread=0.1, friction_spread=0.1)), SEED)
for k in range(4000):
    if k % 20 == 0:
        sim.command(np.array([np.cos(k / 700), np.sin(k / 900)]), 0.2)
    sim.step()
    if k % 4 == 0:
        pose = sim.measured_pose()
numbers = (*sim.state.position.tolist(), *sim.state.velocity.tolist(), *pose.position.tolist())
print(len(sim.take_impacts()), *(x.hex() for x in numbers))
"""


def test_a_seed_gives_the_same_run_bit_by_bit_in_any_process(capsys):
    told = []
    for seed in ("4", "5", "4"):
        exec(compile(STORY.replace("SEED", seed), "story", "exec"), {})
        told.append(capsys.readouterr().out)
    elsewhere = subprocess.run(
        [sys.executable, "-c", STORY.replace("SEED", "4")], capture_output=True, text=True, timeout=60, check=True
    )
    assert told[0] == told[2] == elsewhere.stdout
    assert told[0] != told[1]
    assert int(told[0].split()[0]) >= 3


def test_start_inside_an_obstacle_is_an_error():
    world = make_world(circles=[(0.0, 0.0, 0.2)])
    with pytest.raises(WorldError, match=r"\(0\.25, 0\) stands 0\.04 m inside .*radius 0\.09"):
        Simulator(world, QUIET, 0, start=np.array([0.25, 0.0]))


@pytest.mark.parametrize("start", [(0.05, 1.0), (3.0, 1.0), (np.nan, 1.0)])
def test_start_in_or_beyond_a_wall_is_an_error(start):
    world = make_world(walled=True, bounds=(0.0, 0.0, 2.0, 2.0))
    with pytest.raises(WorldError, match="start"):
        Simulator(world, QUIET, 0, start=np.array(start))


def test_a_world_without_a_start_needs_one():
    with pytest.raises(WorldError, match="has none"):
        Simulator(make_world(), QUIET, 0)


def test_start_noise_never_puts_it_into_an_obstacle():
    world = make_world(walled=True, bounds=(0.0, 0.0, 2 * RADIUS + 0.004, 1.0))
    starts = [
        Simulator(world, noisy(), seed, start=np.array([RADIUS + 0.002, 0.5])).state.position for seed in range(30)
    ]
    assert np.abs(np.array(starts)[:, 0] - RADIUS - 0.002).max() <= 0.002
    assert np.std(starts, axis=0)[1] > 0.005


def test_reset_puts_it_back_at_rest_while_time_goes_on():
    sim = Simulator(OPEN, noisy(), 2)
    start = sim.state.position
    drive(sim, (1.0, 0.5), 0.5, 1.0)
    sim.reset()
    assert (sim.state.position == start).all()
    assert not sim.state.velocity.any()
    assert sim.state.yaw == 0.0
    assert sim.time == 1.0
    sim.step()
    assert (sim.state.position == start).all()
