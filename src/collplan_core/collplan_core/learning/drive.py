"""What is believed of the drive, and what motion tells about it."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from collplan_core.parameters import Robot, Settings

NOTHING, DRIVE = "nothing", "drive"
"""Values of robot.learning."""
INTERVAL = 1.645
"""Half the width of an interval that holds nine of ten, in standard deviations."""
STEPS = 0.01, 0.02
"""Shares by which largest acceleration and lag must move until others are used."""
DELAY_STEP = 0.005
"""Steps of the delay in use [s]."""
HIDDEN, SEEN = 0.09, 0.13
"""Largest acceleration times lag: with less than the first, wheel errors hide the lag, and the belief holds; with more
than the second they do not [m/s]."""
UNLIKE = 0.1
"""Share by which the drive must differ from what is set until a person is told, beside what is uncertain."""


class Drive(NamedTuple):
    """The constants of the velocity law that planner and controller use.

    Attributes:
        max_acceleration: [m/s^2]; lag: [s].
        delay: from a pose's stamp to the wheels [s].
    """

    max_acceleration: float
    lag: float
    delay: float


class Learnt(NamedTuple):
    """One constant as motion tells it: its logarithm where `is_log`, a duration [s] else; both normal.

    Attributes:
        middle: median; deviation: standard deviation.
    """

    middle: float
    deviation: float
    is_log: bool = True

    @property
    def value(self) -> float:
        """The median."""
        return math.exp(self.middle) if self.is_log else self.middle

    @property
    def interval(self) -> tuple[float, float]:
        """The ends between which it is in nine of ten."""
        ends = self.middle - INTERVAL * self.deviation, self.middle + INTERVAL * self.deviation
        return (math.exp(ends[0]), math.exp(ends[1])) if self.is_log else (max(ends[0], 0.0), ends[1])


class LearntDrive(NamedTuple):
    """The drive as motion tells it, largest acceleration [m/s^2], lag [s] and delay [s]."""

    max_acceleration: Learnt
    lag: Learnt
    delay: Learnt


def drive_of(robot: Robot) -> Drive:
    """The drive that the parameters tell."""
    return Drive(robot.max_acceleration, robot.velocity_lag, robot.motion_delay)


def with_drive(settings: Settings, drive: Sequence[float] | None) -> Settings:
    """The settings of a robot that drives so; as they are without a drive."""
    if drive is None or tuple(drive) == drive_of(settings.robot):
        return settings
    acceleration, lag, delay = drive
    robot = replace(settings.robot, max_acceleration=acceleration, velocity_lag=lag, motion_delay=delay)
    return replace(settings, robot=robot)


def drive_in_use(belief: Drive, learnt: LearntDrive, spreads: Sequence[float], before: Drive) -> Drive:
    """The drive to use: from the belief to the medians, as those narrow from its `spreads`; as before for small steps.

    A delay that no motion tells apart from the belief stays there.
    """
    narrowed = [known.deviation / spread for known, spread in zip(learnt, spreads, strict=True)]
    shares = [max(0.0, 1.0 - each * each) for each in narrowed]
    seen = (learnt.max_acceleration.value * learnt.lag.value - HIDDEN) / (SEEN - HIDDEN)
    shares[1] *= min(max(seen, 0.0), 1.0)
    acceleration = _between(belief.max_acceleration, learnt.max_acceleration, shares[0])
    lag = _between(max(belief.lag, DELAY_STEP), learnt.lag, shares[1]) if shares[1] > 0.0 else belief.lag
    delay = belief.delay + DELAY_STEP * round(shares[2] * (learnt.delay.value - belief.delay) / DELAY_STEP)
    moved = any(
        abs(new - old) > step * old for new, old, step in zip((acceleration, lag), before[:2], STEPS, strict=True)
    )
    return Drive(acceleration, lag, delay) if moved or delay != before.delay else before


def _between(belief: float, learnt: Learnt, share: float) -> float:
    return math.exp((1.0 - share) * math.log(belief) + share * learnt.middle)


def why_unlike(belief: Drive, learnt: LearntDrive) -> str:
    """Returns in words that the robot accelerates otherwise than is set, beyond doubt; "" where it may be as set."""
    told, (low, high) = belief.max_acceleration, learnt.max_acceleration.interval
    if low / (1.0 + UNLIKE) <= told <= high * (1.0 + UNLIKE):
        return ""
    return f"drives like {learnt.max_acceleration.value:.2f} m/s^2, set to {told:g}"


def described(learnt: LearntDrive) -> str:
    """What motion tells, in words; in brackets where each is in nine of ten."""
    told = []
    for known, words in zip(learnt, ("{} m/s^2", "lag {} s", "delay {} s"), strict=True):
        low, high = known.interval
        told.append(f"{words.format(f'{known.value:.2f}')} ({low:.2f} to {high:.2f})")
    return "drives like " + ", ".join(told)
