"""Filter of motion-capture poses: gives states, detects impacts, and refuses poses that cannot be the robot's.

Velocity and yaw rate are the slope of the least-squares line through the poses of the last `mocap.velocity_window`, the
motion half a window ago: at the default 60 ms it lags by 30 ms (0.045 m/s at 1.5 m/s^2), and 2 mm of noise at 100 Hz
leave 0.04 m/s. The position is the newest one, as measured, without delay. After an impact the line begins at the
impact: it goes through its point and the poses since, so the velocity before it is forgotten at once. A second change
of velocity that soon after it and that way is the rest of the same hit: the line begins there, no impact is reported.

A pose that `robot.max_speed` cannot explain, or whose stamp does not rise, is refused, until `mocap.relocation_time` of
such poses agree with each other. Where stamps did not rise, the motion capture restarted; else the robot was carried
(kidnapped robot), or another body is mistaken for it. This is reported, and only a person may let the robot drive on.

A velocity that the robot cannot have is not published: most often the stamps are wrong, as those of poses that came in
a burst and were stamped at receipt. Then none is believed for `mocap.relocation_time`, and no impact.

A pose that is tipped or off the floor is refused for as long as it is. So is a heading that leaps while the position
goes on: nobody turns a robot like that, but markers that are nearly symmetric are taken for one another. It is trusted
again when it is back, or by the rule above where the position leapt first, or after a silence of
`mocap.relocation_time` or so long off the floor, in which the robot may have been turned.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from collplan_core.impact import Impact
from collplan_core.parameters import Limits, Mocap, Robot, Settings
from collplan_core.poses.impact_detection import (
    ACCELERATION_SHARE,
    IMPACT_REACH,
    FittedImpact,
    detected_impact,
    top_speed,
)
from collplan_core.poses.pose_track import BURST, FittedMotion, track_law, with_pose, with_pose_judged
from collplan_core.poses.shown_acceleration import NOTHING_SHOWN, Shown
from collplan_core.poses.six_degrees import NO_FLOOR, TILT, YAW, Floor, tilt_of, turns, why_off_floor
from collplan_core.state import State


class Deviations(NamedTuple):
    """Standard deviations of a measured motion."""

    position: float  # by axis [m]
    yaw: float  # [rad]
    velocity: float  # by axis [m/s]
    yaw_rate: float  # [rad/s]


EXACT = Deviations(0.0, 0.0, 0.0, 0.0)


def deviations_of(motion: FittedMotion, robot: Robot, mocap: Mocap) -> Deviations:
    """Standard deviations of the newest pose and of the slopes up to it, taken for those at its stamp.

    Meanwhile the wheels may have changed the velocity, and that of a turning rim by as much.
    """
    changed = ACCELERATION_SHARE * robot.max_acceleration * motion.delay
    steepness = 1.0 / math.sqrt(motion.spread)
    return Deviations(
        mocap.position_noise,
        mocap.yaw_noise,
        math.hypot(mocap.position_noise * steepness, changed),
        math.hypot(mocap.yaw_noise * steepness, changed / robot.radius),
    )


CERTAIN = 4.0
"""Noise of the velocity that is allowed for, in mocap.position_noise over mocap.velocity_window."""
MISTAKEN = 2.0
"""Multiple of the largest speed that no single wrong pose makes: the stamps are wrong, and so is what follows."""
EARLY, FADES, RESTS = 0.9, 0.8, 1.5
"""A pose that equals the last counts once so much of the longest time between new ones is over; what remains of that at
each new one; and a longer silence, in limits.pose_age, is a robot that stood."""
SAME_HIT_ANGLE = math.radians(45.0)
"""Largest angle between the two changes of velocity that one hit was found as [rad]; two walls in turn turn further."""

NOT_FINITE, ZEROS, QUATERNION, STAMP, LEAP = "not_finite", "zeros", "quaternion", "stamp", "leap"
SPEED = "speed"
KIDNAPPED = "kidnapped"
"""Reason given beside an accepted pose to which the robot cannot have driven."""


class PoseError(ValueError):
    """Error of a message that holds no valid pose. `reason` is its kind, for counting."""

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason


@dataclass(frozen=True, eq=False)
class PoseSample:
    """One measured pose, world frame."""

    stamp: float  # [s]
    position: np.ndarray  # (2,) [m]
    yaw: float  # heading [rad]
    height: float = 0.0  # position along the vertical [m]
    tilt: float = 0.0  # angle between the body's z axis and the vertical [rad]


def check_pose_fields(
    stamp: float, position: tuple[float, ...], quaternion: tuple[float, ...], tolerance: float
) -> PoseSample:
    """The pose in these fields: stamp [s], position x, y, z [m], quaternion x, y, z, w.

    Raises:
        PoseError: not finite, all zeros, or a quaternion whose norm is off 1 by more than the tolerance.
    """
    values = (stamp, *position, *quaternion)
    if not all(math.isfinite(value) for value in values):
        raise PoseError(NOT_FINITE, f"pose: got {values}, expected finite numbers")
    if not any(position) and not any(quaternion):
        raise PoseError(ZEROS, "pose: got zeros only, as sent while a body is lost")
    x, y, z, w = quaternion
    if abs(math.hypot(x, y, z, w) - 1.0) > tolerance:
        raise PoseError(QUATERNION, f"orientation: got {quaternion}, expected a quaternion of length 1")
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return PoseSample(stamp, np.array(position[:2], dtype=float), yaw, position[2], tilt_of(quaternion))


class Track(NamedTuple):
    """Poses that agree with each other."""

    times: np.ndarray = np.zeros(0)  # (n,) strictly rising [s]
    poses: np.ndarray = np.zeros((0, 3))  # (n, 3) x, y [m] and yaw, not wrapped [rad]
    begun: float = math.nan  # stamp of the first pose, also where that is no longer kept [s]
    received: float = math.nan  # local time at which the newest pose was received [s]
    newest: PoseSample | None = None  # the newest pose; None before the first
    burst: float = -math.inf  # stamp of the newest pose that came in a burst [s]
    renewed: float = 0.0  # time between the last two poses that differed [s]
    changed: float = math.nan  # stamp of the last one that did [s]


NO_TRACK = Track()


class FilterMemory(NamedTuple):
    """The filter's memory between two poses."""

    track: Track = NO_TRACK  # the robot's
    suspects: Track = NO_TRACK  # track of refused poses that may turn out to be a relocation
    suspected: str = ""  # reason why the first of them was refused
    impact: Impact | None = None  # the last impact found in the track, None before the first
    floor: Floor = NO_FLOOR  # the plane on which the robot drives
    shown: Shown = NOTHING_SHOWN  # accelerations that it has shown
    heard: float = math.inf  # local time of receipt of the newest pose on the floor, refused or not [s]
    mistrusted: float = -math.inf  # local time until which no velocity is believed, after one that cannot be [s]
    unseen: bool = False
    """Whether none arrived for mocap.relocation_time since the last accepted one: the robot may have turned."""


FRESH = FilterMemory()


class FilterResult(NamedTuple):
    """The result of filtering one pose."""

    state: State | None  # None when the pose was refused or left out, or while the first window fills
    impact: Impact | None = None  # an impact, once, when it is found; else None
    refused: str = ""  # kind of a refusal, empty when accepted: not_finite, tilt, height, stamp, leap, yaw or speed
    why: str = ""  # why it was refused: what came, what was expected, and the parameter to look at
    relocated: bool = False  # whether the robot is somewhere else now; plans are then invalid
    kidnapped: bool = False  # whether it is, and not by stamps alone: somebody has moved it, or it is another body
    yaw_rate: float = math.nan  # yaw rate of the state [rad/s]
    deviations: Deviations = EXACT  # standard deviations of state and yaw rate
    speed: float = math.nan  # speed that the poses show [m/s]


def filter_pose(
    memory: FilterMemory, sample: PoseSample, received: float, settings: Settings
) -> tuple[FilterResult, FilterMemory]:
    """Filters one pose that was received at a local time [s]; uses settings.robot, .mocap and .limits.pose_age."""
    if not _is_finite(sample):
        return _refusal(NOT_FINITE, f"{described_pose(sample)}, expected finite numbers"), memory
    x, y = sample.position.tolist()
    lift = memory.floor.lift(x, y, sample.height)
    off_floor = why_off_floor(sample.tilt, lift, settings.mocap)
    if (off_floor == TILT and _is_momentary(memory.track, sample, settings.mocap)) or _is_repeated(
        memory.track, sample
    ):
        return FilterResult(None), memory
    if off_floor:
        # in the air it may be turned, as where nothing is seen of it
        words = _words_off_floor(off_floor, sample, lift, settings.mocap)
        return _refusal(off_floor, words), memory._replace(suspects=NO_TRACK)
    if memory.floor.is_new(x, y):
        memory = memory._replace(floor=memory.floor.with_height(x, y, sample.height))
    refused = _disagreement(memory.track, sample, received, settings)
    goes_on = _goes_on(memory.suspects, sample, received, settings)
    leapt = goes_on and memory.suspected == LEAP
    # a robot whose poses were refused for so long stands: no distance is explained by the time that goes on
    if leapt and not refused and sample.stamp - memory.suspects.begun > settings.limits.pose_age:
        refused = LEAP
    if not refused:
        return _accepted(memory, memory.track, sample, received, settings)
    result = _refusal(refused, _words_of_disagreement(refused, sample, memory.track, settings))
    unseen = memory.unseen or received - memory.heard > settings.mocap.relocation_time
    memory = memory._replace(heard=received, unseen=unseen)
    # what has leapt and turned is a leap also where the silence explains the distance by now
    if refused == YAW and not unseen and not leapt:
        return result, memory._replace(suspects=NO_TRACK)
    if not goes_on:
        memory = memory._replace(suspects=Track(begun=sample.stamp), suspected=refused)
    law, suspects = track_law(settings.robot, settings.mocap), memory.suspects
    if sample.stamp - suspects.begun < settings.mocap.relocation_time - law.slack:
        x, y = sample.position.tolist()
        times, poses = with_pose(suspects.times, suspects.poses, sample.stamp, x, y, sample.yaw, law)
        suspects = Track(times, poses, suspects.begun, received, sample)
        return result, memory._replace(suspects=suspects)
    result, taken = _accepted(memory._replace(impact=None), suspects, sample, received, settings)
    return result._replace(relocated=True, kidnapped=memory.suspected != STAMP), taken


def speed_limit(settings: Settings) -> float:
    """Returns the largest speed that poses may show, noise included [m/s]."""
    mocap = settings.mocap
    return top_speed(settings.robot) + CERTAIN * mocap.position_noise / mocap.velocity_window


def warm_up() -> None:
    """Compiles the filter by a pose that is taken and one that has leapt, so that no pose has to wait for it."""
    memory = FRESH
    for stamp, x in ((0.0, 0.0), (0.01, 1.0)):
        memory = filter_pose(memory, PoseSample(stamp, np.array([x, 0.0]), 0.0), stamp, Settings())[1]


def _accepted(
    memory: FilterMemory, track: Track, sample: PoseSample, received: float, settings: Settings
) -> tuple[FilterResult, FilterMemory]:
    """The result of a pose that a track goes on with, and the memory with that track, cut at an impact."""
    if _begins_anew(track, sample, settings.limits):
        track = Track(begun=sample.stamp)
    x, y = sample.position.tolist()
    law = track_law(settings.robot, settings.mocap, memory.shown.most)
    burst = _newest_burst(track, sample, settings.mocap)
    before = track.begun, sample.stamp - burst < settings.mocap.relocation_time
    times, poses, fit, slope = with_pose_judged(
        track.times, track.poses, before, sample.stamp, x, y, sample.yaw, (*law[:-1], tuple(law.impacts))
    )
    impact, motion = detected_impact(FittedImpact(*fit), settings.robot.radius), FittedMotion(*slope)
    told = None if _is_same_hit(impact, memory.impact, settings.mocap) else impact
    track = Track(times, poses, track.begun, received, sample, burst, *_renewal(track, sample, settings.limits))
    shown = memory.shown.anew()
    if impact is None and not math.isnan(motion.vx):
        deviation = settings.mocap.position_noise / math.sqrt(motion.spread)
        shown = memory.shown.with_velocity(sample.stamp, motion.vx, motion.vy, deviation)
    taken = FilterMemory(
        track,
        impact=impact or memory.impact,
        floor=memory.floor,
        shown=shown,
        heard=received,
        mistrusted=memory.mistrusted,
    )
    if math.isnan(motion.vx):
        return FilterResult(None, told), taken
    speed, limit = math.hypot(motion.vx, motion.vy), speed_limit(settings)
    if speed > MISTAKEN * limit:
        taken = taken._replace(mistrusted=received + settings.mocap.relocation_time)
    if speed > limit or received < taken.mistrusted:
        return _refusal(SPEED, _words_of_speed(speed, sample, memory.track, settings), speed), taken
    state = State(sample.stamp, sample.position, np.array((motion.vx, motion.vy)), sample.yaw)
    deviations = deviations_of(motion, settings.robot, settings.mocap)
    return FilterResult(state, told, yaw_rate=motion.yaw_rate, deviations=deviations, speed=speed), taken


def _is_finite(sample: PoseSample) -> bool:
    values = sample.stamp, *sample.position.tolist(), sample.yaw, sample.height, sample.tilt
    return all(map(math.isfinite, values))


def _is_momentary(track: Track, sample: PoseSample, mocap: Mocap) -> bool:
    """Returns whether poses have been wrong for so short that the robot is known all the same, as while it shakes."""
    return track.newest is not None and 0.0 < sample.stamp - track.newest.stamp <= mocap.velocity_window


def _equals_newest(track: Track, sample: PoseSample) -> bool:
    newest = track.newest
    # a measured yaw differs nearly always
    return newest is not None and sample.yaw == newest.yaw and bool((sample.position == newest.position).all())


def _is_repeated(track: Track, sample: PoseSample) -> bool:
    """Returns whether a pose that equals the last was sent before the next was measured, as by a driver that polls."""
    return 0.0 < sample.stamp - track.changed < EARLY * track.renewed and _equals_newest(track, sample)


def _renewal(track: Track, sample: PoseSample, limits: Limits) -> tuple[float, float]:
    """`renewed` and `changed` of a track that goes on with a pose."""
    if _equals_newest(track, sample):
        return track.renewed, track.changed
    since = sample.stamp - track.changed
    return max(since, FADES * track.renewed) if since <= RESTS * limits.pose_age else track.renewed, sample.stamp


def _newest_burst(track: Track, sample: PoseSample, mocap: Mocap) -> float:
    """Stamp of the newest pose that came in a burst [s]."""
    last = float(track.times[-1]) if len(track.times) else -math.inf
    return sample.stamp if sample.stamp - last < BURST * mocap.velocity_window else track.burst


def _is_same_hit(impact: Impact | None, last: Impact | None, mocap: Mocap) -> bool:
    """Returns whether an impact is the rest of the last one, which was detected before it was over."""
    if impact is None or last is None or impact.time - last.time > IMPACT_REACH * mocap.impact_window:
        return False
    along = float(impact.change @ last.change)
    return along > math.cos(SAME_HIT_ANGLE) * float(np.hypot(*impact.change)) * float(np.hypot(*last.change))


def _disagreement(track: Track, sample: PoseSample, received: float, settings: Settings) -> str:
    """Returns the reason why a pose cannot follow a track; "" where it can."""
    newest = track.newest
    if newest is None:
        return ""
    if sample.stamp <= newest.stamp:
        return STAMP
    # a stamp that runs ahead of the local clock buys no distance
    silence = min(sample.stamp - newest.stamp, received - track.received + settings.limits.pose_age)
    mocap = settings.mocap
    reach = top_speed(settings.robot) * max(silence, 0.0) + mocap.leap_margin
    # once the wheels are commanded zero, a spin does not last
    turned = not turns(sample.yaw - newest.yaw, min(silence, settings.limits.pose_age), mocap)
    # where the heading alone is wrong, so is the centre that was computed with it
    lever = 2.0 * math.hypot(mocap.body_offset_x, mocap.body_offset_y) if turned else 0.0
    if math.dist(sample.position.tolist(), newest.position.tolist()) > reach + lever:
        return LEAP
    return YAW if turned else ""


def _goes_on(track: Track, sample: PoseSample, received: float, settings: Settings) -> bool:
    """Returns whether a pose continues an existing track."""
    return not _begins_anew(track, sample, settings.limits) and not _disagreement(track, sample, received, settings)


def _begins_anew(track: Track, sample: PoseSample, limits: Limits) -> bool:
    """Returns whether a pose is the first of a track, or the first after a gap."""
    return track.newest is None or sample.stamp - track.newest.stamp > limits.pose_age


# ---- a refusal in words


def described_pose(sample: PoseSample) -> str:
    """Returns a pose in words."""
    place = ", ".join(f"{value:.3f}" for value in (*sample.position.tolist(), sample.height))
    return f"pose {place}, yaw {sample.yaw:.2f}, tilt {sample.tilt:.2f} at {sample.stamp:.3f}"


def _refusal(kind: str, why: str, speed: float = math.nan) -> FilterResult:
    return FilterResult(None, refused=kind, why=why, speed=speed)


def _words_off_floor(kind: str, sample: PoseSample, lift: float, mocap: Mocap) -> str:
    if kind == TILT:
        limit = f"expected at most {mocap.max_tilt:.2f} (mocap.max_tilt): mocap.axes ({mocap.axes})?"
        return f"tilted by {sample.tilt:.2f} rad, {limit}"
    return f"{lift:.3f} m off the floor, expected at most {mocap.max_lift:g} (mocap.max_lift): mocap.axes, mocap.units?"


def _words_of_disagreement(kind: str, sample: PoseSample, track: Track, settings: Settings) -> str:
    newest, mocap = track.newest, settings.mocap
    if newest is None:
        return described_pose(sample)
    away, silence = math.dist(sample.position, newest.position), sample.stamp - newest.stamp
    if kind == STAMP:
        late = f"{sample.stamp:.3f} s is not later than the last, {newest.stamp:.3f} s"
        return f"{late}: does the receiver stamp its poses?"
    if kind == LEAP:
        limit = f"expected at most robot.max_speed {settings.robot.max_speed:g} m/s: mocap.units ({mocap.units})?"
        return f"{away:.2f} m within {silence:.3f} s to {described_pose(sample)}, {limit}"
    turned = math.degrees(math.remainder(sample.yaw - newest.yaw, math.tau))
    limit = f"expected at most mocap.max_spin {mocap.max_spin:g} rad/s: are the markers nearly symmetric?"
    return f"turned by {turned:.0f} degrees within {silence:.3f} s, {limit}"


def _words_of_speed(shown: float, sample: PoseSample, track: Track, settings: Settings) -> str:
    """Why poses that show this speed [m/s], the newest of which follows a track, are not believed."""
    limit = speed_limit(settings)
    if shown > limit:
        times = track.times[track.times >= sample.stamp - settings.mocap.velocity_window]
        span = sample.stamp - float(times[0]) if len(times) else 0.0
        found = f"{len(times) + 1} poses within {1000.0 * span:.1f} ms move at {shown:.2f} m/s"
    else:
        found = f"poses moved faster than {limit:.2f} m/s less than {settings.mocap.relocation_time:g} s ago"
    return f"{found}, expected at most {limit:.2f}: does the receiver stamp at receipt (mocap.rate)? mocap.units?"
