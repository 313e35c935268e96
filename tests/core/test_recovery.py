"""What the planner decides about a robot that is stuck, without a node; it plans with the straight planner."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from straight_planner import STRAIGHT

from collplan_core.control.back_out import DISTANCE, SPACING, SPEED, back_out
from collplan_core.deadline import never
from collplan_core.goal import ABORTED, ACCEPTED
from collplan_core.loop.decisions import WARNING
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.plan import NoPlan
from collplan_core.planners import PLANNERS
from collplan_core.sensing.felt_obstacles import with_felt
from loop_scenes import AHEAD, IDENTITY, SETTINGS, at, cycles, notices, scan_at, see, statuses

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
    """How far along x the disc can go by a map [m]."""
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


def test_a_new_goal_begins_anew():
    robot = Stuck()
    robot.stays(1.0)
    robot.loop.take_goal(IDENTITY[::-1], ASIDE, robot.now)
    robot.decisions.clear()
    while len(robot.warnings) < TRIES and robot.loop.goal.active:
        robot.stays(0.1)
    assert robot.loop.goal.active


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
        robot.loop.take_hand()
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
    felt = with_felt(scan, state, np.array([[cx, cy]]), RADIUS)
    changed = ~np.equal(felt.ranges, scan.ranges)
    assert (felt.ranges[changed] < scan.ranges[changed]).all()
    ends = state.position + felt.ranges[changed, None] * np.column_stack(
        [np.cos(felt.angles[changed]), np.sin(felt.angles[changed])]
    )
    finite = np.isfinite(felt.ranges[changed])
    np.testing.assert_allclose(np.hypot(*(ends[finite] - (cx, cy)).T), RADIUS, atol=1e-6)
    if np.hypot(cx - x, cy - y) <= RADIUS:
        assert not changed.any()
