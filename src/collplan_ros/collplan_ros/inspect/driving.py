"""What a recording shows of the robot's own motion: speed, braking, drive and restitution."""

import math
from collections.abc import Iterator

import numpy as np

from collplan_core.impact import Impact
from collplan_core.learning.drive import MEANT, SEEN, LearntDrive
from collplan_core.parameters import Robot
from collplan_ros.inspect.found import Findings, Found
from collplan_ros.inspect.recording import Recording
from collplan_ros.inspect.stages import Stages
from collplan_ros.messages.reading import twist_of

STEP = 0.05
"""Speeds are taken over two such steps, and accelerations over six [s]."""
STAYS = 5.0
"""Time at the largest speed shown, while commands ask for more, from which on it is the robot's largest [s]."""
BEYOND = 1.3
"""Multiple of what is set from which on a speed or acceleration is another: the noise of poses makes less."""
STARTS, BUMPS = "record the commands, and start and stop ten times at full speed", "bump a wall three times at 0.5 m/s"
DRIVEN = ("robot.max_acceleration", "robot.velocity_lag", "robot.motion_delay")
SURER = 1.96 / 1.645
"""From an interval of nine in ten to one of 95 in 100."""
LEAST, MOST = ((0.15, 0.0), (0.0, 0.05), (0.1, 0.03)), ((0.5, 0.0), (0.7, 0.0), (0.0, 0.06))
"""Smallest uncertainties of largest acceleration, lag and delay, and those from which they are not told: a share, and
more [SI]. Wheels that err less than the learner takes them to seem slower."""
SATURATES = 0.5
"""Largest share of the commands' size by which speed lags behind under the largest acceleration, so that it shows."""
CLEAR, HEAD_ON, AGREE, REBOUND_FLOOR = 0.25, 0.95, 0.25, 0.1
"""Speed into a wall of an impact that is taken [m/s], the cosine of its incidence, by which friction tells little, the
uncertainty of a restitution beyond which the impacts do not agree, and the smallest: wheels that still push into the
wall make it seem less."""


def find_motion(findings: Findings, way: np.ndarray, recording: Recording, robot: Robot) -> None:
    """Adds the largest speed and acceleration, where they are beyond what is set, or the commands beyond them."""
    grid = np.arange(way[0, 0], way[-1, 0], STEP)
    places = np.column_stack([np.interp(grid, way[:, 0], way[:, k]) for k in (1, 2)])
    velocities = (places[2:] - places[:-2]) / (2.0 * STEP)
    if len(velocities) < 20:
        return
    speeds = np.hypot(*velocities.T)
    shown = float(np.percentile(speeds, 99.5))
    # a base that is still accelerating has not shown its largest speed
    stays = STEP * int((speeds > 0.9 * shown).sum()) > STAYS
    asked = _asked(recording)
    if shown > BEYOND * robot.max_speed or (stays and asked > 1.2 * shown > 0.1):
        findings.found["robot.max_speed"] = Found(round(1.05 * shown, 3), round(0.1 * shown, 3))
    else:
        findings.missing["robot.max_speed"] = "record commands, and drive at full speed for 5 s"
    # a bump is over sooner than the wheels accelerate: each third of a change must have its part
    changes = velocities[6:] - velocities[:-6]
    along = changes / np.maximum(np.hypot(*changes.T), 1e-9)[:, None]
    thirds = [
        ((velocities[k + 2 : len(velocities) - 4 + k] - velocities[k : k - 6]) * along).sum(axis=1) for k in (0, 2, 4)
    ]
    sustained = float(np.min(thirds, axis=0).max()) / (2.0 * STEP)
    if sustained > BEYOND * robot.max_acceleration:
        findings.found["robot.max_acceleration"] = Found(round(1.1 * sustained, 2), round(0.2 * sustained, 2))


def _asked(recording: Recording) -> float:
    """Largest speed commanded [m/s]."""
    twists = [twist_of(message).linear for _, message in recording.commands]
    return max((math.hypot(each.x, each.y) for each in twists), default=0.0)


def find_driven(findings: Findings, recording: Recording, stages: Stages) -> None:
    """Adds what the stages learnt from a recording that they passed with the findings so far: drive and restitution."""
    learnt = stages.drive.learnt
    if learnt is not None:
        for key, value in _drive_found(learnt, _asked(recording)):
            findings.found.setdefault(key, value)
    findings.missing.update(dict.fromkeys((key for key in DRIVEN if key not in findings.found), STARTS))
    restitution = restitution_of(stages.impacts)
    if restitution is None:
        findings.missing["rebound.restitution"] = BUMPS
    else:
        findings.found["rebound.restitution"] = restitution
    findings.check()


def _drive_found(learnt: LearntDrive, asked: float) -> Iterator[tuple[str, Found]]:
    # below, errors of the wheels hide the lag; far above, the robot never accelerates as much as it can
    gap = learnt.max_acceleration.value * learnt.lag.value
    hidden = SATURATES * asked < gap, gap < SEEN, False
    for key, each, hides, *bounds in zip(DRIVEN, learnt, hidden, LEAST, MOST, strict=True):
        least, most = (share * each.value + more for share, more in bounds)
        wide = math.hypot(SURER * max(each.high - each.value, each.value - each.low), least)
        if each.known > MEANT and wide < most and not hides:
            yield key, Found(round(each.value, 3), round(wide, 3))


def restitution_of(impacts: list[Impact]) -> Found | None:
    """Speed after over speed before along the normal, of at least three clear impacts that agree; else None."""
    shares = []
    for impact in impacts:
        into, back = impact.speed_into, float(impact.velocity_after @ impact.normal)
        if into > max(CLEAR, HEAD_ON * float(np.hypot(*impact.velocity_before))) and back > 0.0:
            shares.append(back / into)
    n = len(shares)
    if n < 3:
        return None
    # nearly Student's factor for so few
    sure = math.hypot(2.0 * n / (n - 1.6) * float(np.std(shares, ddof=1)) / math.sqrt(n), REBOUND_FLOOR)
    return Found(round(float(np.mean(shares)), 3), round(sure, 3)) if sure <= AGREE else None
