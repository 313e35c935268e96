"""Following a rollout: the command that makes a robot with a lag drive it, contacts and all."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.command import FREE_SPACE
from collplan_core.control.feed_forward import feed_forward
from collplan_core.control.follow import K_I, ControllerMemory, follow
from collplan_core.control.reference import found_reference
from collplan_core.plan import timed_path
from collplan_core.reflection import rebound
from collplan_core.state import State
from collplan_core.time_to_goal_planner.full_plan import sample_trajectory
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, robot_model
from collplan_core.velocity_law import velocity_after
from scenes import box, map_of, rotation, unit, world_of
from time_to_goal_scenes import (
    BOUNDS,
    RADIUS,
    SETTINGS,
    faces_field,
    motion_in,
    open_field,
    problem_over,
    with_strategy,
)

FEW = settings(max_examples=12)
PERIOD = 1.0 / SETTINGS.controller.rate
LAG, A_MAX, SPEED = SETTINGS.robot.velocity_lag, SETTINGS.robot.max_acceleration, SETTINGS.robot.max_speed
MODEL = robot_model(with_strategy("bounce"))
WALL_AT = 0.35
BEARING = 0.4
NORMAL = -unit(BEARING)
OPEN = problem_over(open_field(half_side=2.0), (1.9, 1.9))
WALL = problem_over(faces_field((BEARING + np.pi, WALL_AT), half_side=2.0), (-1.9, -1.9))
"""Met by the disc's centre at a distance of WALL_AT from (0, 0)."""


def rollout(problem, state, commands) -> tuple[np.ndarray, np.ndarray]:
    """Rows t, x, y, vx, vy and contacts under commands (n, 2), one a control interval."""
    return sample_trajectory(problem, motion_in(problem, state), np.array(commands, dtype=float), RADIUS)


def forward_at(rows: np.ndarray, now: float, lead: float = 0.0) -> np.ndarray:
    reference = found_reference(rows[:, 0], rows[:, 1:3], A_MAX)
    return np.array(feed_forward(reference, now, PERIOD, MODEL.wheels, BOUNDS, lead))


def open_loop(rows: np.ndarray, duration: float, wall: bool, phase: int = 0) -> np.ndarray:
    """(n, 5) t, x, y, vx, vy every ms of a robot driven by the feed-forward alone; its ticks come late by phase."""
    (x, y, vx, vy), h, result = rows[0, 1:], 1e-3, []
    command = forward_at(rows, 0.0)
    for k in range(round(duration / h)):
        if (k - phase) % round(PERIOD / h) == 0:
            command = forward_at(rows, k * h)
            command = command / max(1.0, np.hypot(*command) / SPEED)
        wx, wy = velocity_after(MODEL.wheels, vx, vy, *command, h)
        x, y = x + 0.5 * (vx + wx) * h, y + 0.5 * (vy + wy) * h
        vx, vy = wx, wy
        if wall and WALL_AT + (x, y) @ NORMAL < 0.0 and (vx, vy) @ NORMAL < 0.0:
            vx, vy = rebound(np.array([vx, vy]), NORMAL, MODEL.ring)
        result.append(((k + 1) * h, x, y, vx, vy))
    return np.array(result)


def at(rows: np.ndarray, times: np.ndarray) -> np.ndarray:
    return np.column_stack([np.interp(times, rows[:, 0], rows[:, a]) for a in (1, 2)])


bearings = st.floats(-np.pi, np.pi)
changes = st.lists(st.tuples(st.floats(0.0, 0.95 * SPEED), bearings), min_size=2, max_size=4)


def spread_over(changes, intervals: int) -> np.ndarray:
    targets = np.array([speed * unit(bearing) for speed, bearing in changes])
    return targets[np.arange(intervals) * len(targets) // intervals]


@FEW
@given(changes=changes, speed=st.floats(0.0, SPEED), bearing=bearings, phase=st.sampled_from([0, 20, 49]))
def test_driven_by_it_alone_a_robot_stays_on_the_rollout(changes, speed, bearing, phase):
    rows, _ = rollout(OPEN, [0.0, 0.0, *(speed * unit(bearing))], spread_over(changes, 24))
    came = open_loop(rows, 1.0, wall=False, phase=phase)
    assert np.hypot(*(came[:, 1:3] - at(rows, came[:, 0])).T).max() < 0.01


def test_it_drives_into_an_intended_contact_without_braking_and_on_from_it():
    for speed, incidence in ((SPEED, 0.0), (SPEED, 0.9), (0.8, -0.5)):
        toward = speed * unit(BEARING + incidence)
        until = math.ceil(WALL_AT / (toward @ unit(BEARING)) / CONTROL_INTERVAL)
        commands = np.vstack([np.tile(toward, (until, 1)), np.tile(0.8 * NORMAL, (24 - until, 1))])
        rows, contacts = rollout(WALL, [0.0, 0.0, *toward], commands)
        for phase in (0, 20, 49):
            came = open_loop(rows, 1.0, wall=True, phase=phase)
            apart = np.hypot(*(came[:, 1:3] - at(rows, came[:, 0])).T)
            hit = int(np.argmax(np.hypot(*np.diff(came[:, 3:], axis=0).T) > 0.2))
            assert came[hit, 3:] @ -NORMAL == pytest.approx(toward @ -NORMAL, rel=0.05)
            assert came[hit, 0] == pytest.approx(contacts[0, 0], abs=3e-3)
            assert apart[:hit].max() < 2e-3
            # a command holds on for up to half a period too long or ends as much too early, at full acceleration
            assert apart.max() < 0.5 * PERIOD * A_MAX * (1.0 - contacts[0, 0]) + 5e-3


def straight(velocity_at, n: int = 41, step: float = 0.025) -> np.ndarray:
    times = step * np.arange(n)
    speeds = np.array([velocity_at(t) for t in times])
    x = np.concatenate([[0.0], np.cumsum(step * np.array([velocity_at(t + 0.5 * step) for t in times[:-1]]))])
    return np.column_stack([times, x, np.zeros(n), speeds, np.zeros(n)])


def test_by_hand_at_constant_velocity_and_acceleration():
    """Held for a period it has to change the velocity by a T; the lag lets through 1 - exp(-T / lag) of the lead."""
    for now in (0.0, 0.013, 0.4, 0.9):
        np.testing.assert_allclose(forward_at(straight(lambda t: 0.7), now), (0.7, 0.0), atol=1e-9)
        expected = 0.8 * now + 0.8 * PERIOD / (1.0 - np.exp(-PERIOD / LAG))
        np.testing.assert_allclose(forward_at(straight(lambda t: 0.8 * t), now), (expected, 0.0), atol=1e-9)
    # where the acceleration begins the velocity lies between those of the steps beside it
    command = forward_at(straight(lambda t: 0.5 + 0.8 * max(0.0, t - 0.5)), 0.46)
    np.testing.assert_allclose(command, (0.5 + 0.011 / (1.0 - np.exp(-PERIOD / LAG)), 0.0), atol=1e-6)
    # at full acceleration what the lag takes for it, beyond where the velocity will be
    expected = 1.2 - A_MAX * 0.3 - A_MAX * (PERIOD + LAG)
    np.testing.assert_allclose(forward_at(straight(lambda t: 1.2 - A_MAX * t), 0.3), (expected, 0.0), atol=1e-3)


def test_at_full_acceleration_the_command_leads_farther_and_an_error_turns_it_less():
    slowing = straight(lambda t: 1.2 - A_MAX * t)
    np.testing.assert_allclose(forward_at(slowing, 0.3, 0.6), (1.2 - A_MAX * 0.3 - 0.6, 0.0), atol=1e-3)
    for acceleration in (0.8, 1.1 * A_MAX):  # less than full, and more than any command makes of it
        other = straight(lambda t, a=acceleration: a * t)
        np.testing.assert_allclose(forward_at(other, 0.3, 0.6), forward_at(other, 0.3), atol=1e-9)
    gathering = straight(lambda t: 0.5 + A_MAX * t if t < 0.4 else 1.1)
    np.testing.assert_allclose(forward_at(gathering, 0.3, 0.6), (SPEED, 0.0), atol=1e-3)  # no faster than the robot
    # without errors the robot does the same; an error across of 0.1 m/s moves it less aside
    velocity, aside = np.array([1.2 - A_MAX * 0.3, 0.0]), np.array([0.0, 0.1])
    for lead, most in ((0.0, 0.04), (0.6, 0.015)):
        command = forward_at(slowing, 0.3, lead)
        after = np.array(velocity_after(MODEL.wheels, *velocity, *command, PERIOD))
        np.testing.assert_allclose(after, velocity - (A_MAX * PERIOD, 0.0), atol=1e-3)
        assert 0.005 < velocity_after(MODEL.wheels, *velocity, *(command + aside), PERIOD)[1] < most


def test_by_hand_a_period_that_holds_a_bounce_belongs_to_its_longer_part():
    bouncing = straight(lambda t: 1.0 if t < 0.5 else -0.7)
    for now, velocity in ((0.3, 1.0), (0.45, 1.0), (0.47, 1.0), (0.48, -0.7), (0.5, -0.7), (0.6, -0.7)):
        np.testing.assert_allclose(forward_at(bouncing, now), (velocity, 0.0), atol=1e-9)


def test_the_controller_adds_what_leads_back_to_the_rollout():
    rows, hall = straight(lambda t: 0.5), map_of(world_of([box(2.0, -3.0, 2.2, 3.0)]))
    plan = timed_path(10.0, 10.0 + rows[:, 0], np.ascontiguousarray(rows[:, 1:3]), rows[:, 3:])
    here = State(10.4, np.array([0.21, -0.02]), np.zeros(2), 0.0)
    command, memory = follow(ControllerMemory(), plan, hall, here, 10.4, SETTINGS)
    np.testing.assert_allclose(command.reference, (0.2, 0.0), atol=1e-9)
    gain = SETTINGS.controller.k_p
    beside = (gain + K_I / SETTINGS.controller.rate) * 0.02
    np.testing.assert_allclose(command.velocity, (0.5 - gain * 0.01, beside), atol=1e-9)
    assert command.maneuver == FREE_SPACE
    unpushed = replace(memory, integral=np.zeros(2))
    turned, _ = follow(unpushed, plan, hall, replace(here, yaw=np.pi / 2), 10.4, SETTINGS)
    np.testing.assert_allclose(rotation(np.pi / 2) @ turned.velocity, command.velocity, atol=1e-9)
    assert turned.yaw_rate < 0.0  # back to the heading held
