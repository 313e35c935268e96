"""The drive of the robot: the one believed, the one learnt, and the one in use between them."""

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from collplan_core.parameters import Robot, Settings

OFF, DRIVE = "off", "drive"
"""Values of robot.learning."""
STEPS, DELAY_STEP = (0.01, 0.02), 0.005
"""Shares by which largest acceleration and lag must move until others are used, and steps of the delay in use [s]."""
HIDDEN, SEEN = 0.04, 0.08
"""Largest acceleration times lag: below the first, errors of the wheels hide the lag, and the belief holds; above the
second they do not [m/s]."""
UNLIKE, LATER = 0.1, 0.02
"""Share of what is set by which acceleration or lag must differ from it, beside what is uncertain, until a person is
told, and the same of the delay [s]."""
MEANT = 0.5
"""A constant of which less is `known` is not told to a person: its interval may be wrong."""
WORDS = ("like {:.2f} m/s^2", "with a lag of {:.2f} s", "with a delay of {:.2f} s")
"""Forms of the three constants in a sentence."""


class Drive(NamedTuple):
    """The constants of the velocity law that planner and controller use."""

    max_acceleration: float  # [m/s^2]
    lag: float  # [s]
    delay: float  # from a pose's stamp to the wheels [s]


class Learnt(NamedTuple):
    """One constant as motion tells it: its median, and the ends between which it is in nine of ten.

    `known` is the share that this counts beside the belief: 0 as long as motion tells nothing, up to 1.
    """

    value: float
    low: float
    high: float
    known: float


class LearntDrive(NamedTuple):
    """The drive as motion tells it: largest acceleration [m/s^2], lag [s] and delay [s]."""

    max_acceleration: Learnt
    lag: Learnt
    delay: Learnt

    def __str__(self) -> str:
        """In words, with intervals."""
        words = zip(WORDS, self, strict=True)
        told = (f"{form.format(each.value)} ({each.low:.2f} to {each.high:.2f})" for form, each in words)
        return f"drives {', '.join(told)}"

    def why_unlike(self, belief: Drive) -> str:
        """Names what differs beyond doubt from what is believed; "" where nothing does."""
        beyond = UNLIKE * belief.max_acceleration, UNLIKE * belief.lag, LATER
        unlike = [
            f"{form.format(each.value)}, set to {told:g}"
            for form, each, told, more in zip(WORDS, self, belief, beyond, strict=True)
            if each.known > MEANT and not each.low - more <= told <= each.high + more
        ]
        return f"drives {'; '.join(unlike)}" if unlike else ""


def drive_of(robot: Robot) -> Drive:
    """The drive that the parameters tell."""
    return Drive(robot.max_acceleration, robot.velocity_lag, robot.motion_delay)


_MADE: deque[tuple[Settings, Drive, Settings]] = deque(maxlen=4)
"""The newest settings of `with_drive`: planner and controller share them, and what is kept for settings by identity."""


def with_drive(settings: Settings, drive: Sequence[float] | None) -> Settings:
    """The settings of a robot that drives so; as they are without a drive.

    The same settings and drive, soon again, give the same object.
    """
    if drive is None or tuple(drive) == drive_of(settings.robot):
        return settings
    used = Drive(*drive)
    for given, told, made in tuple(_MADE):
        if given is settings and told == used:
            return made
    acceleration, lag, delay = used
    robot = replace(settings.robot, max_acceleration=acceleration, velocity_lag=lag, motion_delay=delay)
    made = replace(settings, robot=robot)
    _MADE.append((settings, used, made))
    return made


def drive_in_use(belief: Drive, learnt: LearntDrive, before: Drive) -> Drive:
    """The drive to use: from the belief to the medians, as more is known; that of before where it hardly moves."""
    acceleration, lag, delay = learnt
    seen = min(max((acceleration.value * lag.value - HIDDEN) / (SEEN - HIDDEN), 0.0), 1.0)
    pulls = acceleration.known, lag.known * seen
    pairs = zip(belief[:2], (acceleration.value, lag.value), pulls, strict=True)
    now = [told ** (1.0 - pull) * value**pull if pull > 0.0 else told for told, value, pull in pairs]
    steps = round(delay.known * (delay.value - belief.delay) / DELAY_STEP)
    moved = (abs(new - old) > step * old for new, old, step in zip(now, before[:2], STEPS, strict=True))
    used = Drive(now[0], now[1], max(belief.delay + DELAY_STEP * steps, 0.0))
    return used if any(moved) or used.delay != before.delay else before
