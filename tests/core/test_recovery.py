"""When a robot counts as stuck, and what the planner does about it; it plans with the straight planner."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from straight_planner import STRAIGHT

from collplan_core.control.back_out import DISTANCE, SPACING, SPEED, back_out
from collplan_core.control.stuck import COMMANDED, PARTS, PAUSE, SHARE, WINDOW, why_stuck
from collplan_core.deadline import never
from collplan_core.goal import ABORTED, ACCEPTED
from collplan_core.loop.decisions import WARNING
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import Settings
from collplan_core.plan import NoPlan
from collplan_core.planners import PLANNERS
from collplan_core.scans.filters import add_bumped_obstacles
from collplan_core.velocity_law import velocity_after, velocity_law
from loop_scenes import AHEAD, IDENTITY, SETTINGS, at, cycles, notices, scan_at, see, statuses
from scenes import rotation

TRIES = SETTINGS.planner.recovery_tries
RADIUS = SETTINGS.robot.radius
FORWARD = np.array([0.5, 0.0])
ASIDE = AHEAD + np.array([0.0, 0.2])
CAME = 0.4
"""Along so much of the x axis the robot comes before it is stuck [m]."""


@pytest.fixture(autouse=True)
def straight(monkeypatch):
    monkeypatch.setitem(PLANNERS, "custom", STRAIGHT)


class Stuck:
    """A loop whose robot came along x at 0.5 m/s and does not get on."""

    def __init__(self, setting=SETTINGS) -> None:
        self.loop = PlannerLoop(setting, lambda each: never)
        self.decisions, self.now, self.x = [], 1.0, 0.0
        see(self.loop, self.now)
        assert statuses(self.loop.take_goal(IDENTITY, AHEAD, self.now)) == [ACCEPTED]
        self.run(CAME / 0.5, lambda x: x + 0.005)
        self.decisions.clear()

    def run(self, duration: float, moved, velocity=FORWARD) -> None:
        for k in range(round(duration / 0.01)):
            self.now += 0.01
            self.x = moved(self.x)
            if k % 5 == 0:
                self.loop.take_command(np.array(velocity), self.now)
                self.decisions += see(self.loop, self.now, x=self.x)
            else:
                self.decisions += self.loop.take_pose(at(self.now, self.x), self.now)
            if k % 10 == 9:
                self.decisions += self.loop.cycle(self.now)

    def stays(self, duration: float, velocity=FORWARD) -> None:
        self.run(duration, lambda x: x, velocity)

    @property
    def warnings(self) -> list[str]:
        return [text for level, text in notices(self.decisions) if level == WARNING]


def ahead(local_map) -> float:
    reach = local_map.border_points - local_map.position
    return local_map.position[0] + reach[(np.abs(reach[:, 1]) < 0.02) & (reach[:, 0] > 0.0), 0].min()


def test_within_a_second_it_backs_out_along_where_it_came_from_and_says_so():
    robot = Stuck()
    robot.stays(1.0)
    assert len(robot.warnings) == 1
    assert all(part in robot.warnings[0] for part in ("0.40, 0.00", "0.50 m/s", f"try 1 of {TRIES}"))
    plan = cycles(robot.decisions)[-1].plan
    np.testing.assert_allclose(plan.positions[[0, -1]], [[CAME, 0.0], [CAME - DISTANCE, 0.0]], atol=0.02)
    # no other plan is made until that one has ended
    before = len(cycles(robot.decisions))
    robot.run(plan.times[-1] - robot.now - 0.01, lambda x: x - 0.003, -FORWARD)
    assert len(cycles(robot.decisions)) == before
    robot.run(0.6, lambda x: x, (0.0, 0.0))
    assert cycles(robot.decisions)[-1].plan.positions[-1, 0] == AHEAD[0]


def test_after_so_many_tries_the_goal_is_given_up_with_the_reason():
    for tries in [0, 1, 3]:
        robot = Stuck(SETTINGS.with_values({"planner.recovery_tries": tries}))
        for _ in range(tries + 1):
            robot.stays(1.0)
        assert len(robot.warnings) == tries, tries
        assert statuses(robot.decisions)[-1] == ABORTED, tries
        assert all(part in robot.loop.trouble for part in ("stuck", f"{tries} tries of planner.recovery_tries")), tries


def test_a_goal_that_is_given_again_and_again_gets_no_more_tries():
    robot = Stuck()
    for k in range(20):
        robot.stays(0.3)
        if not robot.loop.goal.active:
            break
        robot.loop.take_goal(bytes([k]) * 16, AHEAD, robot.now)
    assert len(robot.warnings) == TRIES
    assert statuses(robot.decisions)[-1] == ABORTED


def test_a_goal_that_is_given_again_keeps_what_was_felt_and_another_does_not():
    robot = Stuck()
    robot.stays(1.0)
    for goal, felt in ((AHEAD, True), (ASIDE, False)):
        robot.loop.take_goal(IDENTITY, goal, robot.now)
        robot.stays(0.3, np.zeros(2))
        assert (ahead(cycles(robot.decisions)[-1].local_map) < CAME + 0.1) == felt


def test_what_was_felt_is_forgotten_where_it_leaves_no_way(monkeypatch):
    def plan(memory, local_map, *arguments):
        if ahead(local_map) < local_map.position[0] + 0.5:
            raise NoPlan("closed off")
        return STRAIGHT.plan(memory, local_map, *arguments)

    monkeypatch.setitem(PLANNERS, "custom", replace(STRAIGHT, plan=plan))
    robot = Stuck()
    robot.stays(1.0)
    robot.run(DISTANCE / SPEED, lambda x: x - 0.003, -FORWARD)
    robot.run(0.5, lambda x: x, (0.0, 0.0))
    assert robot.loop.goal.active
    last = cycles(robot.decisions)[-1]
    assert last.plan.positions[-1, 0] == AHEAD[0]
    assert ahead(last.local_map) > robot.x + 0.5


def test_without_a_goal_or_a_command_to_move_nobody_is_stuck_nor_is_one_that_a_hand_pushes():
    robot = Stuck()
    robot.stays(3.0, (0.1, 0.0))
    robot.loop.cancel()
    robot.stays(3.0)
    assert robot.warnings == []
    robot = Stuck()
    for _ in range(8):
        robot.stays(0.3)
        robot.loop.take_manual_command()
    assert robot.warnings == []
    robot.stays(1.0)
    assert len(robot.warnings) == 1


coordinates = st.floats(-1.0, 1.0)
trails = st.lists(st.tuples(coordinates, coordinates), max_size=6).map(lambda points: np.array(points).reshape(-1, 2))


@given(trail=trails, x=coordinates, y=coordinates, angle=st.floats(-3.2, 3.2), max_speed=st.floats(0.05, 2.0))
def test_the_plan_that_backs_out_is_slow_short_and_begins_where_the_robot_is(trail, x, y, angle, max_speed):
    pushed = np.array([np.cos(angle), np.sin(angle)])
    plan = back_out(at(5.0, x, y), trail, pushed, max_speed)
    assert plan.stamp == plan.times[0] == 5.0
    np.testing.assert_allclose(plan.positions[0], (x, y), atol=1e-12)
    assert (np.diff(plan.times) > 0.0).all()
    steps = np.hypot(*np.diff(plan.positions, axis=0).T)
    assert steps.max() <= SPACING + 1e-9
    assert steps.sum() <= DISTANCE + 1e-6
    assert (steps / np.diff(plan.times)).max() <= min(SPEED, max_speed) + 1e-9


@given(x=st.floats(-0.9, 2.9), y=st.floats(-0.4, 0.4), cx=coordinates, cy=coordinates)
def test_a_felt_disc_only_shortens_beams_and_only_where_it_is(x, y, cx, cy):
    state = at(1.0, x, y)
    scan = scan_at(state)
    felt = add_bumped_obstacles(scan, state, np.array([[cx, cy]]), RADIUS)
    changed = ~np.equal(felt.ranges, scan.ranges)
    assert (felt.ranges[changed] < scan.ranges[changed]).all()
    ends = state.position + felt.ranges[changed, None] * np.column_stack(
        [np.cos(felt.angles[changed]), np.sin(felt.angles[changed])]
    )
    finite = np.isfinite(felt.ranges[changed])
    np.testing.assert_allclose(np.hypot(*(ends[finite] - (cx, cy)).T), RADIUS, atol=1e-6)
    if np.hypot(cx - x, cy - y) <= RADIUS:
        assert not changed.any()


ROBOT = Settings().robot
ACCELERATION = ROBOT.max_acceleration
NOISE = 0.002
rates = st.sampled_from([30.0, 100.0, 240.0])
seeds = st.integers(0, 2**31)


def standing(duration: float, rate: float = 100.0, seed: int = 0) -> np.ndarray:
    times = np.arange(0.0, duration + 1e-9, 1.0 / rate)
    noise = np.random.default_rng(seed).normal(0.0, NOISE, (len(times), 2))
    return np.column_stack([times, noise])


def commanded(speed: float, duration: float, period: float = 0.05) -> np.ndarray:
    times = np.arange(0.0, duration + 1e-9, period)
    return np.column_stack([times, np.full(len(times), speed), np.zeros(len(times))])


def driven(speed, duration, noise=0, slow=(0.0, 0.0), begin=0.0, robot=ROBOT) -> np.ndarray:
    """Poses of a robot that takes on a commanded speed along x by its own law; zero is commanded within `slow` [s]."""
    law, step = velocity_law(robot), 0.01
    v, x = begin, 0.0
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


@given(slow=st.sets(st.integers(7, 19), max_size=8), speed=st.floats(0.0, COMMANDED - 1e-6))
def test_slow_commands_count_as_a_pause_where_they_last_longer_than_that(slow, speed):
    commands = commanded(1.0, 1.0)
    commands[list(slow), 1] = speed
    reason = why_stuck(standing(1.0), commands, ACCELERATION)
    assert bool(reason) == (len(slow) * 0.05 < PAUSE)


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
    heavy = replace(ROBOT, max_acceleration=ACCELERATION / mass, velocity_lag=ROBOT.velocity_lag * mass)
    poses = driven(speed, 2.0, seed, begin=-speed, robot=heavy)
    poses[:, 1:] = poses[:, 1:] @ rotation(angle).T
    for last in range(71, len(poses)):
        assert why_stuck(poses[: last + 1], commanded(speed, 2.0), ACCELERATION) == "", poses[last, 0]
