"""When a robot counts as stuck: commanded, and not moving."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.control.stuck import COMMANDED, PARTS, PAUSE, SHARE, WINDOW, why_stuck
from collplan_core.parameters import Settings
from collplan_core.velocity_law import velocity_after, velocity_law
from scenes import rotation

ROBOT = Settings().robot
ACCELERATION = ROBOT.max_acceleration
NOISE = 0.002
rates = st.sampled_from([30.0, 100.0, 240.0])
seeds = st.integers(0, 2**31)


def standing(duration: float, rate: float = 100.0, seed: int = 0) -> np.ndarray:
    """Poses of a robot that does not move, with the noise of a motion capture."""
    times = np.arange(0.0, duration + 1e-9, 1.0 / rate)
    noise = np.random.default_rng(seed).normal(0.0, NOISE, (len(times), 2))
    return np.column_stack([times, noise])


def commanded(speed: float, duration: float, period: float = 0.05) -> np.ndarray:
    times = np.arange(0.0, duration + 1e-9, period)
    return np.column_stack([times, np.full(len(times), speed), np.zeros(len(times))])


def driven(speed: float, duration: float, noise: int = 0, slow: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Poses of a robot that takes on a commanded speed along x from rest, by its own law; zero is within `slow` [s]."""
    law, step = velocity_law(ROBOT), 0.01
    v = x = 0.0
    rows = [(0.0, 0.0, 0.0)]
    for k in range(1, round(duration / step) + 1):
        asked = 0.0 if slow[0] <= (k - 1) * step < slow[1] else speed
        w, _ = velocity_after(law, v, 0.0, asked, 0.0, step)
        x, v = x + 0.5 * (v + w) * step, w
        rows.append((k * step, x, 0.0))
    poses = np.array(rows)
    poses[:, 1:] += np.random.default_rng(noise).normal(0.0, NOISE, (len(poses), 2))
    return poses


@given(speed=st.floats(COMMANDED, 1.2), rate=rates, seed=seeds)
def test_commanded_and_not_moving_is_noticed_within_a_second(speed, rate, seed):
    times = np.arange(0.05, 1.0, 0.01)
    noticed = [t for t in times if why_stuck(standing(t, rate, seed), commanded(speed, t), ACCELERATION)]
    assert noticed
    assert WINDOW <= noticed[0] < 1.0


@given(speed=st.floats(0.0, COMMANDED - 1e-6), duration=st.floats(0.0, 3.0))
def test_without_a_command_nobody_is_stuck(speed, duration):
    assert why_stuck(standing(duration), commanded(speed, duration), ACCELERATION) == ""
    assert why_stuck(standing(duration), np.zeros((0, 3)), ACCELERATION) == ""
    assert why_stuck(np.zeros((0, 3)), commanded(1.0, duration), ACCELERATION) == ""


@given(slow=st.sets(st.integers(7, 19), max_size=8), speed=st.floats(0.0, COMMANDED - 1e-6))
def test_slow_commands_count_as_a_pause_where_they_last_longer_than_that(slow, speed):
    """A plan that begins anew at each bump begins slowly."""
    commands = commanded(1.0, 1.0)
    commands[list(slow), 1] = speed
    reason = why_stuck(standing(1.0), commands, ACCELERATION)
    assert bool(reason) == (len(slow) * 0.05 < PAUSE)


@given(angle=st.floats(-np.pi, np.pi), speed=st.floats(COMMANDED, 1.2))
def test_commands_to_and_fro_lead_nowhere(angle, speed):
    """As those of a robot that comes back from a wall and is sent to it again, with no sensor that sees it."""
    to_and_fro = commanded(speed, 1.0)
    # the window holds seven of each and one that lasts no time
    to_and_fro[-8:, 1] = -speed
    to_and_fro[:, 1:] = to_and_fro[:, 1:] @ rotation(angle).T
    poses = standing(1.0)
    poses[:, 1] += 0.01 * np.sin(2.0 * np.pi * poses[:, 0] / 0.35)
    assert why_stuck(poses, to_and_fro, ACCELERATION) == ""
    still = np.column_stack([poses[:, 0], np.zeros((len(poses), 2))])
    assert why_stuck(still, to_and_fro, ACCELERATION) == ""


@given(speed=st.floats(COMMANDED, 1.2), begin=st.floats(0.0, 1.5), slow=st.floats(0.0, PAUSE), seed=seeds)
def test_a_robot_that_does_as_commanded_is_not_stuck_round_a_pause(speed, begin, slow, seed):
    poses, told = driven(speed, 2.5, seed, (begin, begin + slow)), commanded(speed, 2.5, 0.01)
    told[(told[:, 0] >= begin) & (told[:, 0] < begin + slow), 1] = 0.0
    for last in range(71, len(poses), 3):
        assert why_stuck(poses[: last + 1], told[: last + 1], ACCELERATION) == "", poses[last, 0]


def test_by_hand_what_counts_as_moving():
    # 0.4 m/s for 0.7 s is 0.28 m; a share of it, steadily: the mean places of five parts span four fifths of the way
    poses = standing(1.0)
    poses[:, 1:] = 0.0
    way = SHARE * 0.4 * WINDOW * PARTS / (PARTS - 1) * poses[:, 0] / WINDOW
    reasons = []
    for size in (0.95, 1.05):
        poses[:, 1] = size * way
        reasons.append(why_stuck(poses, commanded(0.4, 1.0), ACCELERATION))
    assert reasons[1] == ""
    assert all(number in reasons[0] for number in ("0.40 m/s", "0.7 s", "0.04 m"))


@given(speed=st.floats(0.3, 1.2), mass=st.floats(1.0, 2.0), angle=st.floats(-np.pi, np.pi), seed=seeds)
def test_a_robot_that_turns_round_is_not_stuck_even_if_it_is_twice_as_heavy(speed, mass, angle, seed):
    """As after a rebound: it moves against its command at first."""
    law = velocity_law(replace(ROBOT, max_acceleration=ACCELERATION / mass, velocity_lag=ROBOT.velocity_lag * mass))
    step, v, x, rows = 0.01, -speed, 0.0, []
    for k in range(200):
        rows.append((k * step, x, 0.0))
        w, _ = velocity_after(law, v, 0.0, speed, 0.0, step)
        x, v = x + 0.5 * (v + w) * step, w
    poses = np.array(rows)
    poses[:, 1:] = poses[:, 1:] @ rotation(angle).T
    poses[:, 1:] += np.random.default_rng(seed).normal(0.0, NOISE, (len(poses), 2))
    for last in range(71, len(poses)):
        assert why_stuck(poses[: last + 1], commanded(speed, 2.0), ACCELERATION) == "", poses[last, 0]
