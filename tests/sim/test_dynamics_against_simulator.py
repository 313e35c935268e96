"""The dynamics against the simulated robot without noise: the same commands from a state."""

from functools import cache
from itertools import product

import numpy as np
import pytest

from collplan_core.plane import rotate
from collplan_core.time_to_goal_planner.boundary_memory.clearance import OBSERVED
from collplan_core.time_to_goal_planner.dynamics import motion_at
from collplan_core.time_to_goal_planner.full_plan import sample_trajectory
from collplan_core.time_to_goal_planner.known_map import given_map
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, Problem, problem_of
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths
from collplan_core.worlds import World
from omnipuck_sim.robot.physics import Simulator
from physics_scenes import QUIET, RADIUS, make_world, unit

SETTINGS = QUIET.with_values({"planner.strategy": "bounce", "remembered.side": 4.0})
SPEED = SETTINGS.robot.max_speed
INTERVALS = round(1.0 / CONTROL_INTERVAL)
ORIGIN = np.zeros(2)
FAR_AWAY = np.array([-1.7, -1.7])


@cache
def tilted_wall(bearing: float) -> World:
    """A wall whose face the disc's centre meets at 0.3 m in the direction of the bearing."""
    along, out = unit(bearing + np.pi / 2), unit(bearing)
    near = (0.3 + RADIUS) * out
    return make_world([[near - 1.5 * along, near - 1.5 * along + 0.3 * out, near + 1.5 * along + 0.3 * out,
                        near + 1.5 * along][::-1]])  # fmt: skip


OPEN = make_world()
CORNER = make_world(walled=True, bounds=(-2.0, -2.0, 0.3 + RADIUS, 0.25 + RADIUS))


@cache
def problem_in(world: World) -> Problem:
    remembered = given_map(world, SETTINGS).remembered
    assert remembered is not None
    paths = shortest_paths(remembered.field, FAR_AWAY, ORIGIN, SETTINGS)
    return problem_of(remembered.field, remembered.free, paths, SETTINGS)


def rollout(world: World, velocity, commands) -> tuple[np.ndarray, np.ndarray]:
    """Rows t, x, y, vx, vy and rebounds of a second from the origin, under commands (n, 2), one a control interval."""
    problem = problem_in(world)
    initial = motion_at(problem.clearance, problem.constants.grid, 0.0, 0.0, *map(float, velocity))
    rows, contacts = sample_trajectory(problem, initial, np.array(commands, dtype=float), RADIUS)
    return rows, contacts[contacts[:, 8] == OBSERVED]


def simulated(world: World, velocity, command_at, period: float) -> tuple[np.ndarray, list]:
    """The true states t, x, y, vx, vy over a second, and the impacts; commands are in the world frame."""
    simulator = Simulator(world, SETTINGS, 0, start=ORIGIN)
    simulator.place(ORIGIN, np.array(velocity))
    steps = round(period * SETTINGS.simulator.physics_rate)
    rows = []
    for k in range(round(1.0 / period)):
        command = command_at(k * period)
        for _ in range(steps):
            simulator.command(np.array(rotate(*command, -simulator.state.yaw)), 0.0)
            simulator.step()
            rows.append((simulator.time, *simulator.state.position, *simulator.state.velocity))
    return np.array(rows), simulator.take_impacts()


def apart(rows: np.ndarray, truth: np.ndarray) -> float:
    there = np.column_stack([np.interp(truth[:, 0], rows[:, 0], rows[:, a]) for a in (1, 2)])
    return float(np.hypot(*(truth[:, 1:3] - there).T).max())


def compared(world: World, velocity, commands) -> tuple[float, np.ndarray, list]:
    """How far rollout and truth come apart under the same commands, the contacts foreseen and the impacts."""
    rows, contacts = rollout(world, velocity, commands)
    truth, impacts = simulated(world, velocity, lambda time: commands[round(time / CONTROL_INTERVAL)], CONTROL_INTERVAL)
    return apart(rows, truth), contacts, impacts


def assert_foreseen(contacts: np.ndarray, impacts: list, place: float, direction: float) -> None:
    """Contact by contact in time, within a distance [m] of its place and an angle [rad] of its direction."""
    assert len(contacts) == len(impacts)
    for (time, x, y, vx, vy, *_), impact in zip(contacts, impacts, strict=True):
        assert time == pytest.approx(impact.time, abs=0.01)
        assert np.hypot(*(impact.point - (x, y))) < place
        cosine = impact.velocity_after @ (vx, vy) / np.hypot(*impact.velocity_after) / np.hypot(vx, vy)
        assert cosine > np.cos(direction)


def test_without_a_contact_a_second_ends_within_3_mm():
    for seed in range(6):
        random = np.random.default_rng(seed)
        targets = np.array([random.uniform(0.0, SPEED) * unit(random.uniform(-np.pi, np.pi)) for _ in range(3)])
        commands = targets[np.arange(INTERVALS) * 3 // INTERVALS]
        distance, contacts, impacts = compared(OPEN, random.uniform(0.0, 0.8, 2), commands)
        assert distance < 0.003, seed
        assert len(contacts) == len(impacts) == 0, seed


def test_a_second_with_a_bounce_off_a_flat_wall_ends_within_1_cm():
    for case in product([0.3, 1.9, np.pi], np.radians([-65.0, -30.0, 0.0, 45.0]), [0.8, SPEED]):
        bearing, incidence, speed = case
        toward = speed * unit(bearing + incidence)
        meets = 0.3 / (speed * np.cos(incidence))
        # onward under other commands once it is back from the wall
        onward = 0.9 * unit(bearing + np.pi + 0.5 * incidence)
        commands = [toward if k * CONTROL_INTERVAL < meets else onward for k in range(INTERVALS)]
        distance, contacts, impacts = compared(tilted_wall(bearing), toward, commands)
        assert distance < 0.01, case
        assert len(contacts) == (1 if meets < 0.99 else 0), case
        assert_foreseen(contacts, impacts, 0.005, np.radians(4.0))


def test_a_second_with_bounces_in_a_corner_ends_within_1_cm():
    for bearing in np.radians([27.0, 30.0, 50.0, 60.0]):
        velocity = SPEED * unit(bearing)
        distance, contacts, impacts = compared(
            CORNER, velocity, [velocity if k < 9 else (-0.4, -0.9) for k in range(INTERVALS)]
        )
        assert distance < 0.01, bearing
        assert len(contacts) == 2, bearing
        assert_foreseen(contacts, impacts, 0.006, np.radians(5.0))
    # pressed into it: bounce after bounce, each lower, down to contacts that slide
    for command in [(1.0, 0.5), (0.4, 1.1), (1.2, 0.3)]:
        distance, contacts, impacts = compared(CORNER, (1.0, 0.6), np.tile(command, (INTERVALS, 1)))
        assert distance < 0.015, command
        assert min(len(contacts), len(impacts)) >= 2, command
