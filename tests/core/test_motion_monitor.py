"""What commands and measured motion say of each other, on a robot that follows the believed law, late or turned."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.command import FREE_SPACE, Command
from collplan_core.control.motion_monitor import LATE, OK, REVERSED, SLIP, STUCK, MotionRecord, judge_motion
from collplan_core.loop.motion_watch import MotionWatch
from collplan_core.movers.record import NO_MOVERS
from collplan_core.parameters import Settings
from collplan_core.state import State
from scenes import commanded, mover_at, posed, rotation

SETTINGS = Settings()
STEP, CONTROL = 0.005, 0.05
NO_TURN = np.eye(2)


class Drive:
    """A robot that takes on commands by the believed law, `delay` late, with another mass or turned ones."""

    def __init__(self, delay=0.0, mass=1.0, matrix=NO_TURN, seed=0, touching=lambda now: False, stalls=(), push=0.0):
        self.record, self.verdicts = posed(MotionRecord(), State(-STEP, *np.zeros((2, 2)), 0.0), -STEP, False), []
        self.delay, self.mass, self.matrix, self.touching, self.stalls = delay, mass, matrix, touching, stalls
        self.random, self.push = np.random.default_rng(seed), push
        self.commands, self.position, self.velocity, self.way = [(-1e9, np.zeros(2))], np.zeros(2), np.zeros(2), 0.0
        self.earlier = [np.zeros(2)] * round(0.5 * SETTINGS.mocap.velocity_window / STEP)

    def run(self, wanted, until, begin=0.0):
        """Commands `wanted(time)` from `begin` on, while poses come with noise as shipped."""
        robot, busy, pushed = SETTINGS.robot, -1.0, np.zeros(2)
        for k in range(round(begin / STEP), round(until / STEP)):
            now = k * STEP
            if k % round(CONTROL / STEP) == 0 and now >= busy:
                verdict, self.record = judge_motion(self.record, now, SETTINGS)
                self.verdicts.append((now, verdict))
                command = np.asarray(wanted(now), dtype=float)
                busy = now + next((0.2 for stall in self.stalls if abs(stall - now) < 1e-6), 0.0)
                self.commands.append((busy, command))
                self.record = commanded(self.record, command, now)
                pushed = self.push * self.random.standard_normal(2)
            if k % 2 == 0:
                # as a slope over a window, so half of it old
                velocity = self.earlier[0] + self.random.normal(0.0, 0.04, 2)
                state = State(now, self.position + self.random.normal(0.0, 0.002, 2), velocity, 0.0)
                self.record = posed(self.record, state, now, self.touching(now))
            applied = next(u for time, u in reversed(self.commands) if time <= now - self.delay)
            pull = (self.matrix @ applied - self.velocity) / (robot.velocity_lag * self.mass)
            largest = robot.max_acceleration / self.mass
            pull *= min(1.0, largest / max(np.hypot(*pull), 1e-12))
            self.earlier = [*self.earlier[1:], self.velocity]
            self.velocity = self.velocity + STEP * (pull + pushed)
            self.position = self.position + STEP * self.velocity
            self.way += STEP * float(np.hypot(*self.velocity))
        return self

    @property
    def kinds(self):
        return {verdict.kind for _, verdict in self.verdicts}

    def first(self, kind):
        return next((now for now, verdict in self.verdicts if verdict.kind == kind), math.inf)


def turning(now):
    angle = 1.3 * now + math.sin(2.0 * now)
    return 0.9 * math.cos(angle), 0.9 * math.sin(angle)


def straight(now):
    return 1.0, 0.0


@given(delay=st.floats(0.0, 0.07), mass=st.sampled_from([0.8, 1.0, 1.5, 2.0]), seed=st.integers(0, 1000))
@settings(max_examples=12)
def test_in_time_and_of_any_mass_nothing_is_said(delay, mass, seed):
    assert Drive(delay, mass, seed=seed).run(turning, 6.0).kinds == {OK}


@given(delay=st.floats(0.2, 0.4), seed=st.integers(0, 1000))
@settings(max_examples=12)
def test_late_motion_is_named_within_0_3_s_of_its_onset(delay, seed):
    drive = Drive(delay, seed=seed).run(straight, 1.5)
    assert drive.first(LATE) <= delay + 0.3
    assert "0.10 s" in next(v.reason for _, v in drive.verdicts if v.kind == LATE)


def test_commands_that_the_controller_itself_sent_late_are_not_called_late():
    """It stalls for 0.2 s with a command computed as the robot turns back; 9 of 300 simulated runs were held for it."""
    for seed in range(12):
        drive = Drive(0.03, seed=seed, stalls=[1.0, 1.2, 1.4, 3.0, 3.2, 3.4])
        assert drive.run(lambda now: (1.0 - 2.0 * (int(now / 0.4) % 2), 0.3), 5.0).kinds == {OK}, seed


def test_wheels_that_are_weak_or_strong_for_a_while_are_not_called_late():
    """An error of the acceleration that changes once a period; 12 of 160 simulated trials were held for it."""
    late = [seed for seed in range(20) if LATE in Drive(0.01, seed=seed, push=1.0).run(turning, 6.0).kinds]
    assert late == []


def test_the_delay_is_estimated():
    for delay in [0.0, 0.025, 0.05, 0.075, 0.15, 0.25]:
        drive = Drive(delay).run(turning, 5.0)
        assert drive.record.delay == pytest.approx(delay, abs=0.025), delay


TURNED = {"left": rotation(math.pi / 2), "back": rotation(math.pi), "x": np.diag([-1.0, 1.0])}


def test_turned_axes_are_named_within_0_3_m():
    for name in TURNED:
        drive = Drive(matrix=TURNED[name])
        wanted = (0.7, 0.7) if name == "x" else (1.0, 0.0)
        for k in range(20):
            if REVERSED not in drive.kinds:
                drive.run(lambda now, wanted=wanted: wanted, CONTROL * (k + 1), begin=CONTROL * k)
        assert REVERSED in drive.kinds, name
        assert drive.way <= 0.15, name
        assert drive.kinds <= {OK, REVERSED}, name


@given(
    begin=st.floats(0.5, 3.0),
    brakes=st.floats(0.3, 4.0),
    delay=st.floats(0.0, 0.07),
    mass=st.sampled_from([0.8, 1.0, 1.5, 2.0]),
    seed=st.integers(0, 1000),
)
def test_a_robot_that_only_slows_or_stands_is_never_called_reversed(begin, brakes, delay, mass, seed):
    begin = CONTROL * round(begin / CONTROL)
    drive = Drive(delay, mass, seed=seed).run(turning, begin)
    drive.matrix, drive.mass = np.zeros((2, 2)), brakes
    drive.run(turning, begin + 1.5, begin)
    drive.matrix, drive.mass = NO_TURN, mass
    drive.run(turning, begin + 2.5, begin + 1.5)
    assert REVERSED not in drive.kinds


def test_wheels_almost_without_force_slip_and_those_that_do_not_turn_are_stuck_within_a_second():
    drive = Drive(mass=1e9).run(straight, 3.0)
    assert drive.first(STUCK) <= 1.0
    assert LATE not in drive.kinds
    drive = Drive(mass=25.0).run(turning, 4.0)
    assert SLIP in drive.kinds
    assert not {LATE, REVERSED} & drive.kinds


def test_what_a_wall_does_is_left_out():
    drive = Drive(touching=lambda now: now % 1.0 < 0.05)
    for second in range(1, 8):
        drive.run(turning, float(second), begin=second - 1.0)
        drive.velocity = -drive.velocity
    assert drive.kinds == {OK}


def test_poses_that_come_later_than_they_did_are_late_at_once():
    record = MotionRecord()
    for k in range(200):
        now = 0.01 * k
        record = posed(record, State(now - (0.15 if k > 150 else 0.0), np.zeros(2), np.zeros(2), 0.0), now, False)
        record = commanded(record, np.array([0.1, 0.0]), now)
    verdict, _ = judge_motion(record, 2.0, SETTINGS)
    assert (verdict.kind, "0.15 s" in verdict.reason) == (LATE, True)
    stalled = record
    for k in range(30):
        stalled = posed(stalled, State(2.0 + 0.01 * k, np.zeros(2), np.zeros(2), 0.0), 2.3, False)
    assert judge_motion(stalled, 2.3, SETTINGS)[0].kind != LATE


@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize("paces", [(0.9,), (0.7,), (0.5,), (1.0, 0.5), (1.0, 0.8, 0.95, 0.6)])
def test_slow_simulated_time_is_named_and_never_called_late_poses(paces, noise):
    record, stamp, reason, rng = MotionRecord(), 100.0, "", np.random.default_rng(3)
    for k in range(800):
        stamp += 0.01 * paces[min(k // 100, len(paces) - 1)]
        state = State(stamp, np.array([0.5 * stamp, 0.0]), np.array([0.5, 0.0]), 0.0)
        record = posed(record, state, 0.01 * k + noise * rng.random(), False)
        record = commanded(record, np.array([0.5, 0.0]), 0.01 * k)
        reason = reason or judge_motion(record, 0.01 * k, Settings())[0].reason
    assert "use_sim_time" in reason
    assert "later" not in reason


def test_poses_of_which_one_comes_late_at_once_are_no_slow_time():
    record, verdict = MotionRecord(), None
    for k in range(100):
        state = State(0.01 * k, np.array([0.005 * k, 0.0]), np.array([0.5, 0.0]), 0.0)
        record = posed(record, state, 0.01 * k + 0.3 * (k > 60), False)
        record = commanded(record, np.array([0.5, 0.0]), 0.01 * k)
    verdict, _ = judge_motion(record, 1.3, Settings())
    assert "poses come later than they did" in verdict.reason


BESIDE = SETTINGS.robot.radius + 0.12


@pytest.mark.parametrize(
    ("movers", "pushed"),
    [
        (NO_MOVERS, False),
        (mover_at(BESIDE + 0.02), True),
        (mover_at(BESIDE + 0.05), False),
        (mover_at(BESIDE + 0.10, velocity=(0.6, 0.0)), True),  # it may have turned back since it was seen
        (mover_at(BESIDE + 0.60, velocity=(-0.6, 0.0)), False),
    ],
)
def test_a_mover_beside_the_robot_may_push_it(movers, pushed):
    watch = MotionWatch()
    watch.take_pose(State(0.0, np.zeros(2), np.zeros(2), 0.0), 0.0, True, SETTINGS, movers)
    assert watch.pushed == pushed


@pytest.mark.parametrize("is_seen", [True, False])
def test_a_robot_that_a_mover_pushes_back_gives_no_reason_to_doubt_its_wheels(is_seen):
    watch = MotionWatch()
    for k in range(200):
        now, x = 0.01 * k, -0.005 * k
        watch.take_pose(State(now, np.array([x, 0.0]), np.array([-0.5, 0.0]), 0.0), now, True, SETTINGS,
                        mover_at(x + BESIDE, 0.0, (-0.5, 0.0), now) if is_seen else NO_MOVERS)  # fmt: skip
        if k % 5 == 0:
            watch.commanded(Command(np.array([0.5, 0.0]), 0.0, FREE_SPACE, np.zeros(2)), now)
            watch.judge(now, SETTINGS)
    assert (watch.verdict.kind == SLIP) != is_seen
