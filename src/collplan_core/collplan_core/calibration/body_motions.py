"""The motions from which the place of the measured body on the robot is estimated.

A fixed programme. Slow ones first, which show whether the robot goes and turns as commanded. Where the wheels are so
rough that these do not determine the place, as many faster ones again: the wheels' noise adds up with time, and a
faster motion takes less. The robot stays near where it began, as well as is known by then which way it goes.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from collplan_core.calibration.mocap_offset import ENOUGH_POSITION, ENOUGH_YAW, BodyOffset, body_offset, mean_pose
from collplan_core.calibration.stroke_fit import AxesFit, Stroke, centre, fit_axes
from collplan_core.calibration.turn_fit import FittedTurn, TurnFit, fit_turns
from collplan_core.parameters import Robot
from collplan_core.sensing.pose_filter import PoseSample

HALF_TURN, TURN_TIME = 1.05 * math.pi, 2.1
"""A turn is at least half a revolution long [rad], and takes at least so long [s]."""
CAREFUL_ROUNDS = 4
"""Slow rounds: two turns to the left make a revolution, then two to the right."""
QUICK_ROUNDS = 6
"""Further rounds, where the slow ones leave the offset uncertain: all motions together take two and a half minutes."""
NEAR = 0.04
"""Distance from the beginning from which the robot is not brought back [m]."""
MOST_DISTANCE = 0.4
"""Distance from the beginning at which the motions end, also in the middle of one [m]; what it coasts comes on top."""
STROKES = 4
"""Strokes of a round."""
GOLDEN_ANGLE = 2.4
"""Angle between the ends of one stroke and the next, about the beginning: their directions cover the circle [rad]."""
LONGEST_STROKE = 3.0
"""[s]"""
LARGEST_SHARE = 0.8
"""Largest share of the speed that is spent against a bias of the wheels."""
LEAST_SCALE, MOST_SCALE = 0.5, 2.0
"""Factor of measured over commanded distance beyond which, either way, the robot is not driven back."""
NO_LEVER = np.zeros(2)


class MeasuredRobot(Protocol):
    """A robot that can be driven open loop while the body on it is measured."""

    def drive(
        self, velocity: tuple[float, float], yaw_rate: float, duration: float, is_near: Callable[[PoseSample], bool]
    ) -> list[PoseSample]:
        """The body's poses while a velocity [m/s, robot frame] and a yaw rate [rad/s] are commanded for `duration` [s].

        The command ends before that at the first pose that is not near. The robot is at rest afterwards. No poses at
        all mean that the motion was interrupted and is not used.
        """

    def rest(self) -> list[PoseSample]:
        """Some poses of the body at rest."""


class Strayed(RuntimeError):
    """Error of a robot that is too far from its starting point; the message gives the distance."""


@dataclass(frozen=True)
class Pace:
    """Speeds and reach of the calibration motions.

    Attributes:
        speed: [m/s]; yaw_rate: [rad/s].
        limit: largest commanded speed against a drift [m/s].
        reach: largest distance from the starting point [m].
    """

    speed: float
    limit: float
    yaw_rate: float
    reach: float

    @property
    def turn_time(self) -> float:
        """Duration of a turn [s]."""
        return max(TURN_TIME, HALF_TURN / self.yaw_rate)


def careful(robot: Robot) -> Pace:
    """Pace of a robot whose direction of motion is not known yet."""
    return Pace(min(0.1, robot.max_speed), min(0.3, robot.max_speed), min(1.0, robot.max_yaw_rate), 0.05)


def quick(robot: Robot) -> Pace:
    """The pace once the axes are known to be right."""
    speed = min(0.3, robot.max_speed)
    return Pace(speed, speed, min(3.0, robot.max_yaw_rate), 0.25)


@dataclass(frozen=True, eq=False)
class Motions:
    """The motions driven so far, in order.

    Attributes:
        start, here: the body at rest, before all motions and after the last one.
        turns, strokes: motions that were not interrupted.
    """

    start: PoseSample
    here: PoseSample
    turns: tuple[FittedTurn, ...] = ()
    strokes: tuple[Stroke, ...] = ()


@dataclass(frozen=True, eq=False)
class MotionEstimate:
    """Estimate of the body's offset, from the motions so far.

    Attributes:
        turns: fit of the turns; None where there were none.
        axes: fit of the strokes.
    """

    turns: TurnFit | None
    axes: AxesFit

    @property
    def lever(self) -> np.ndarray:
        """(2,) lever as of `TurnFit`, 0 while it is unknown [m]."""
        return NO_LEVER if self.turns is None else self.turns.lever

    @property
    def offset(self) -> BodyOffset:
        """The body's place on the robot."""
        return body_offset(self.axes, self.turns or TurnFit(NO_LEVER, math.inf, math.nan, math.inf))

    @property
    def is_certain(self) -> bool:
        """True where the offset is known well enough to drive with: the point about which it turns, and its heading."""
        place = math.inf if self.turns is None else self.turns.uncertainty
        return place <= ENOUGH_POSITION and self.axes.uncertainty <= ENOUGH_YAW


def estimate(motions: Motions, lag: float) -> MotionEstimate:
    """The estimate from motions that hold at least two strokes; `lag` [s] of the robot behind its commands."""
    turns = fit_turns(motions.turns, lag) if motions.turns else None
    return MotionEstimate(turns, fit_axes(motions.strokes, NO_LEVER if turns is None else turns.lever))


def drive_each_way(robot: MeasuredRobot, pace: Pace, lag: float) -> Motions:
    """The first motions: forward and back, left and right, twice `pace.reach` each.

    Raises:
        Strayed: it is too far from where it began.
    """
    start = mean_pose(robot.rest())
    motions = Motions(start, start)
    for way in ((1.0, 0.0), (0.0, 1.0)):
        signs = [1.0, -1.0]
        while signs:
            sign, before = signs.pop(0), motions
            velocity = sign * pace.speed * np.array(way)
            motions = _with_stroke(robot, motions, velocity, 2.0 * pace.reach / pace.speed, NO_LEVER)
            if len(motions.strokes) == len(before.strokes):
                # once more, the other way first, so that it stays near
                signs.append(sign)
        known = estimate(motions, lag)
        if LEAST_SCALE < known.axes.scale < MOST_SCALE:
            motions = _to(robot, motions, known, pace, 0.0, NEAR)
    return motions


def one_more_round(robot: MeasuredRobot, motions: Motions, pace: Pace, lag: float) -> Motions:
    """A turn and strokes around the starting point.

    Raises:
        Strayed: it is too far from where it began.
    """
    known, rounds = estimate(motions, lag), len(motions.turns)
    # so that a drift leads across the beginning
    halfway = -0.5 * pace.turn_time * _drift(motions, known.axes)
    motions = _to(robot, motions, known, pace, halfway, NEAR)
    # left, left, right, right
    motions = _with_turn(robot, motions, pace, 1.0 if rounds // 2 % 2 == 0 else -1.0, known.lever)
    known = estimate(motions, lag)
    for _ in range(STROKES):
        target = pace.reach * complex(np.exp(1j * GOLDEN_ANGLE * len(motions.strokes)))
        motions = _to(robot, motions, known, pace, target, 0.0)
    return motions


def _with_turn(robot: MeasuredRobot, motions: Motions, pace: Pace, sign: float, lever: np.ndarray) -> Motions:
    before, rate = motions.here, sign * pace.yaw_rate
    poses, after = _moved(robot, motions.start, lever, (0.0, 0.0), rate, pace.turn_time)
    if not poses:
        return replace(motions, here=after)
    turn = FittedTurn(rate, _driven(poses, pace.turn_time), before, tuple(poses), after)
    return replace(motions, here=after, turns=(*motions.turns, turn))


def _with_stroke(
    robot: MeasuredRobot, motions: Motions, velocity: np.ndarray, duration: float, lever: np.ndarray
) -> Motions:
    before, (vx, vy) = motions.here, velocity.tolist()
    poses, after = _moved(robot, motions.start, lever, (vx, vy), 0.0, duration)
    if not poses:
        return replace(motions, here=after)
    stroke = Stroke(velocity, _driven(poses, duration), before, after)
    return replace(motions, here=after, strokes=(*motions.strokes, stroke))


def _moved(
    robot: MeasuredRobot,
    start: PoseSample,
    lever: np.ndarray,
    velocity: tuple[float, float],
    yaw_rate: float,
    duration: float,
) -> tuple[list[PoseSample], PoseSample]:
    """The body's poses during a motion, and the one at rest after it.

    Raises:
        Strayed: the robot came too far from where it began; while its lever is unknown, the body on it did.
    """

    def away(pose: PoseSample) -> float:
        return abs(centre(pose, lever) - centre(start, lever))

    poses = robot.drive(velocity, yaw_rate, duration, lambda pose: away(pose) <= MOST_DISTANCE)
    after = mean_pose(robot.rest())
    farthest = max(away(pose) for pose in (*poses, after))
    if farthest > MOST_DISTANCE:
        raise Strayed(f"it is {farthest:.2f} m from where it began, at most {MOST_DISTANCE:g} m were expected")
    return poses, after


def _to(
    robot: MeasuredRobot, motions: Motions, known: MotionEstimate, pace: Pace, target: complex, near: float
) -> Motions:
    """Drives to `target` [m, map frame, from the starting point] by the estimate so far, unless it is `near` [m].

    Raises:
        Strayed: it is too far from where it began.
    """
    axes, start, here = known.axes, centre(motions.start, known.lever), centre(motions.here, known.lever)
    way = start + target - here
    if abs(way) <= near:
        return motions
    scale, drift = max(axes.scale, LEAST_SCALE), _drift(motions, axes)
    # against a drift it drives faster, so that it is not slower over the floor
    speed = min(pace.speed + abs(drift) / scale, pace.limit)
    duration, velocity = _against_drift(way, drift, speed * scale)
    commanded = velocity / scale * complex(np.exp(-1j * (axes.turn + motions.here.yaw)))
    if axes.mirrored:
        commanded = commanded.conjugate()
    return _with_stroke(robot, motions, np.array([commanded.real, commanded.imag]), duration, known.lever)


def _drift(motions: Motions, axes: AxesFit) -> complex:
    """The centre's velocity beside what is commanded, at the robot's heading now [m/s, map frame]."""
    return axes.robot_bias * complex(np.exp(1j * motions.here.yaw)) + axes.room_bias


def _against_drift(way: complex, drift: complex, speed: float) -> tuple[float, complex]:
    """Time [s] and velocity [m/s] of a motion that ends `way` [m] from here in spite of a drift, at `speed` [m/s]."""
    if abs(drift) > LARGEST_SHARE * speed:
        drift *= LARGEST_SHARE * speed / abs(drift)
    along = (way * drift.conjugate()).real
    # |way / time - drift| = speed
    rate = (along + math.sqrt(along**2 + abs(way) ** 2 * (speed**2 - abs(drift) ** 2))) / abs(way) ** 2
    return min(1.0 / rate, LONGEST_STROKE), way * rate - drift


def _driven(poses: list[PoseSample], duration: float) -> float:
    """For how long the command was really in force, by the poses' clock [s]: a busy machine ends it late."""
    if len(poses) < 3:
        return duration
    stamps = np.array([pose.stamp for pose in poses])
    return float(stamps[-1] - stamps[0] + np.median(np.diff(stamps)))
