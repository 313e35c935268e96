"""The drive that is learnt, of a robot that follows the velocity law under a course of commands."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.learning.drive import Drive, Learnt, LearntDrive, drive_in_use, drive_of, with_drive
from collplan_core.learning.drive_learner import DriveLearner
from collplan_core.parameters import Settings
from collplan_core.velocity_law import VelocityLaw, velocity_after

BELIEF = Drive(1.5, 0.1, 0.0)
STEP, NOISE = 0.005, 0.002
HARD, GENTLE = 0.6, 0.02


@dataclass
class Robot:
    """A robot of a drive, whose commands lead its velocity by at most `lead` [m/s], and a learner that follows it."""

    drive: Drive
    seed: int = 0
    lead: float = HARD
    error: float = 0.06
    learner: DriveLearner = field(default_factory=lambda: DriveLearner(BELIEF, NOISE))

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(self.seed)
        self.position, self.velocity, self.aim = np.zeros(2), np.zeros(2), np.zeros(2)
        self.commands, self.told, self.steps, self.next_aim = [(-1.0, np.zeros(2))], np.zeros((0, 3)), 0, 0.0

    @property
    def now(self):
        return self.steps * STEP

    def run(self, lasts, measured=lambda now, position: position):
        """Drives on for so long [s]; the learner is told the position that `measured` gives, None for no pose."""
        for _ in range(round(lasts / STEP)):
            law = VelocityLaw(self.drive.max_acceleration, self.drive.lag, 0.0, 1.0)
            if self.steps % 10 == 0:
                self.commands.append(self._command())
            if self.steps % 2 == 0:
                seen = measured(self.now, self.position + self.random.normal(0.0, NOISE, 2))
                if seen is not None:
                    self.learner.take_pose((self.now, *seen.tolist(), 0.0), self.told)
            wanted = next(u for time, u in reversed(self.commands) if time <= self.now + 1e-9)
            after = np.array(velocity_after(law, *self.velocity, *wanted, STEP))
            self.position = self.position + 0.5 * STEP * (self.velocity + after)
            self.velocity = after
            self.steps += 1
        return self.learner.learnt

    def _command(self):
        if self.now >= self.next_aim:
            angle, size = self.random.uniform(0.0, 2.0 * math.pi), self.random.uniform(0.5, 1.2)
            self.aim = (size if self.lead == HARD else 0.1) * np.array([math.cos(angle), math.sin(angle)])
            self.next_aim = self.now + self.random.uniform(0.4, 1.5)
        off = self.aim - self.velocity
        command = self.velocity + off * min(1.0, self.lead / max(float(np.hypot(*off)), 1e-9))
        self.told = np.vstack([self.told[-50:], [self.now, *command]])
        return self.now + self.drive.delay, command + self.random.normal(0.0, self.error, 2)


DRIVES = st.builds(
    Drive,
    st.floats(math.log(0.6), math.log(3.0)).map(math.exp),
    st.floats(math.log(0.05), math.log(0.25)).map(math.exp),
    st.sampled_from([0.0, 0.03, 0.06]),
).filter(lambda drive: drive.max_acceleration * drive.lag < 0.7 * HARD)
"""Drives that saturate where commands lead by HARD."""


def values(learnt):
    return Drive(*(known.value for known in learnt))


@given(drive=DRIVES, seed=st.integers(0, 1000))
@settings(max_examples=12)
def test_any_drive_is_learnt_within_ten_seconds_and_lies_in_its_interval(drive, seed):
    learnt = Robot(drive, seed).run(10.0)
    assert learnt.max_acceleration.value == pytest.approx(drive.max_acceleration, rel=0.04)
    # nine of ten: none of these is far beyond
    for known, true in zip(learnt, drive, strict=True):
        room = 0.5 * (known.high - known.low)
        assert known.low - room <= true <= known.high + room


@pytest.mark.parametrize(
    ("every", "robots"), [(2, 12), *(pytest.param(every, 300, marks=pytest.mark.soak) for every in (2, 4, 10))]
)
def test_intervals_cover_nine_of_ten_and_the_acceleration_is_within_2_per_cent(every, robots):
    drawn = np.random.default_rng(3)
    errors, covered = [], []
    for seed in range(robots):
        drive = Drive(*np.exp(drawn.uniform(np.log([0.6, 0.05]), np.log([2.5, 0.18]))), drawn.choice([0.0, 0.03, 0.06]))
        learnt = Robot(drive, seed).run(10.0, lambda now, at: at if round(now / STEP) % every == 0 else None)
        errors.append(learnt.max_acceleration.value / drive.max_acceleration - 1.0)
        covered.append([known.low <= true <= known.high for known, true in zip(learnt, drive, strict=True)])
    print(f"every {every * STEP:g} s:", np.mean(covered, axis=0), np.sqrt(np.mean(np.square(errors))))
    assert np.sqrt(np.mean(np.square(errors))) < (0.02 if every < 10 else 0.04)
    assert np.mean(covered) >= 0.9


@given(acceleration=st.floats(0.8, 3.0), seed=st.integers(0, 1000))
@settings(max_examples=6)
def test_where_nothing_saturates_the_acceleration_is_not_changed(acceleration, seed):
    robot = Robot(Drive(acceleration, 0.1, 0.0), seed, lead=GENTLE, error=0.0)
    learnt = robot.run(8.0)
    assert drive_in_use(BELIEF, learnt, BELIEF).max_acceleration == pytest.approx(1.5, rel=0.1)
    assert "m/s^2" not in learnt.why_unlike(BELIEF)


@pytest.mark.parametrize(("before", "after"), [(1.5, 0.75), (0.75, 1.5), (1.5, 3.0)])
def test_another_floor_or_load_is_seen_within_three_seconds_of_driving(before, after):
    robot = Robot(Drive(before, 0.15 / before, 0.0), 4)
    robot.run(8.0)
    robot.drive = Drive(after, 0.15 / after, 0.0)
    assert robot.run(3.0).max_acceleration.value == pytest.approx(after, rel=0.1)


def leaping(now, position):
    return position + (0.1 if round(now / STEP) % 40 == 0 else 0.0)


def lost(now, position):
    return None if now % 1.0 < 0.3 else position


@pytest.mark.parametrize("measured", [leaping, lost])
def test_poses_that_leap_or_are_lost_mislead_nobody(measured):
    robot = Robot(Drive(0.75, 0.2, 0.0), 5)
    assert robot.run(10.0, measured).max_acceleration.value == pytest.approx(0.75, rel=0.04)


def test_impacts_that_are_reported_late_cut_off_what_was_measured_since():
    robot = Robot(Drive(1.5, 0.1, 0.0), 7)
    for _ in range(12):
        robot.run(0.6)
        robot.velocity = -0.7 * robot.velocity
        robot.run(0.06)
        robot.learner.take_impact(robot.now)
    assert robot.run(0.5).max_acceleration.value == pytest.approx(1.5, rel=0.04)


def test_what_is_excluded_teaches_nothing():
    robot = Robot(Drive(1.5, 0.1, 0.0), 8)
    robot.run(4.0)
    before = values(robot.learner.learnt)
    robot.learner.exclude(robot.now - 0.12, robot.now + 5.0)
    robot.drive = Drive(0.6, 0.2, 0.0)
    robot.run(4.9)
    assert values(robot.learner.learnt) == before
    robot.learner.begin_anew()
    assert robot.run(4.0).max_acceleration.value == pytest.approx(0.6, rel=0.1)


def told(acceleration, share=0.02, lag=0.1, known=1.0, delay=0.0):
    """What motion may tell; `share` is half the width of the intervals of acceleration and lag."""
    around = (1.0, 1.0 - share, 1.0 + share)
    return LearntDrive(
        Learnt(*(acceleration * each for each in around), known),
        Learnt(*(lag * each for each in around), known),
        Learnt(delay, delay, delay, known),
    )


@pytest.mark.parametrize(
    ("learnt", "before", "used"),
    [
        (told(0.75, lag=0.2), BELIEF, Drive(0.75, 0.2, 0.0)),
        (told(0.75, lag=0.2, known=0.0), BELIEF, BELIEF),  # nothing is known yet
        (told(0.75, lag=0.05), BELIEF, Drive(0.75, 0.1, 0.0)),  # hidden by errors of the wheels
        (told(1.507), BELIEF, BELIEF),  # too small a step
        (told(1.5, lag=0.1, delay=0.031), BELIEF, Drive(1.5, 0.1, 0.03)),
    ],
)
def test_the_drive_in_use(learnt, before, used):
    assert drive_in_use(BELIEF, learnt, before) == pytest.approx(used, rel=2e-3)


@pytest.mark.parametrize(
    ("learnt", "says"),
    [
        (told(1.5, lag=0.28), "drives with a lag of 0.28 s, set to 0.1"),
        (told(0.74, delay=0.05), "drives like 0.74 m/s^2, set to 1.5; with a delay of 0.05 s, set to 0"),
        (told(1.4, delay=0.015), ""),  # within 10 per cent
        (told(0.9, 0.6), ""),  # not sure enough
    ],
)
def test_a_drive_that_is_not_what_is_set_is_told(learnt, says):
    assert learnt.why_unlike(BELIEF) == says


def test_settings_with_a_drive_are_those_of_a_robot_that_drives_so():
    shipped = Settings()
    assert with_drive(shipped, None) is with_drive(shipped, drive_of(shipped.robot)) is shipped
    other = with_drive(shipped, [0.75, 0.2, 0.03])
    assert drive_of(other.robot) == Drive(0.75, 0.2, 0.03)
    assert with_drive(other, drive_of(shipped.robot)) == shipped
