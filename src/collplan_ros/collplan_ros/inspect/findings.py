"""What a recording shows of the parameters: each value found with its uncertainty, and what the motion did not show."""

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import islice

import numpy as np

from collplan_core.calibration.mocap_offset import body_offset
from collplan_core.calibration.stream_quality import stream_quality
from collplan_core.calibration.stroke_fit import AxesFit, Stroke, fit_axes
from collplan_core.mounting.driven import Driven
from collplan_core.mounting.fit import MountFit, fit_mount
from collplan_core.parameters import Settings, all_specs
from collplan_core.poses.mocap_body import MeasuredPose, even_stamp, robot_pose
from collplan_core.poses.pose_filter import PoseError, PoseSample
from collplan_core.scan import Scan, ScanError
from collplan_core.scans.filters import is_masked
from collplan_ros.inspect.body import floor_of, is_upright, lever_of, strokes_of
from collplan_ros.inspect.driving import find_motion
from collplan_ros.inspect.found import DOUBTFUL, OK, WRONG, Findings, Found
from collplan_ros.inspect.ranges import meaning_of, own_posts
from collplan_ros.inspect.recording import Recording
from collplan_ros.messages.mocap_formats import FORMATS
from collplan_ros.messages.reading import (
    MessageError,
    scan_from_message,
    seconds_from_stamp,
    twist_of,
    velocity_from_twist,
)

BEAMS, FARTHEST = 360, 8.0
"""Beams of a scan that are compared at most, and the farthest range [m]."""
AHEAD = 0.05
"""Time by which scans may come before their stamps, as poses come, by the noise of receipt [s]."""
UNEVEN = 0.5
"""Share of the period so soon after the last pose that none is measured: those were stamped at receipt."""
RESTS = 0.25
"""A value repeated for longer is a robot at rest; for less it was not measured again [s]."""
TURN, WAY = "turn once at about 1 rad/s", "drive 2 m straight on"
BOTH_WAYS, ACROSS = (
    "turn in place at about 1 rad/s, once to the left and once to the right",
    "drive 2 m along, and 1 m across",
)
COMMANDED = "record the commands, and drive 2 m straight on and back"
OPEN = "drive where the walls are farther away than the LIDAR reaches"
BODY = ("mocap.body_offset_x", "mocap.body_offset_y")
HEADING_FLOOR, HEADING_KNOWN, PLACE_KNOWN, SLOPE_KNOWN = 0.025, 0.1, 0.02, 0.025
"""Smallest uncertainty of the body's heading on the robot [rad], and those of heading [rad], place [m] and slopes [rad]
beyond which they are not told."""
MOUNT = ("scan.stamp_offset", "scan.offset_x", "scan.offset_y", "scan.offset_yaw")


def wiring(recording: Recording, subject: str) -> dict[str, Found]:
    """Topic, format and frames, which the recording itself names; `subject` is the robot's body."""
    found = {}
    if recording.poses:
        found = {"mocap.format": Found(recording.format), "mocap.topic": Found(recording.topics.poses)}
        for _, measured in islice(_measured(recording, subject), 1):
            found |= {"mocap.frame": Found(measured.frame)} if measured.frame else {}
    if recording.scans:
        found["scan.frame"] = Found(str(recording.scans[0][1].header.frame_id))
    return found


def find(recording: Recording, settings: Settings, said: Callable[[float], None]) -> Findings:
    """The findings of a recording whose wiring the settings have."""
    findings = Findings(wiring(recording, settings.mocap.subject))
    settings = settings.with_values({"mocap.floor_tilt": (0.0, 0.0)})
    settings = settings.with_values(_find_upright(findings, recording, settings))
    poses = _poses(recording, settings)
    if len(poses) > 2:
        _find_pose_stream(findings, poses, settings)
        # found from what is measured of the body itself
        bare = {"mocap.rate": findings.values.get("mocap.rate", settings.mocap.rate)} | dict.fromkeys(BODY, 0.0)
        body = _way(_poses(recording, settings.with_values(bare | {"mocap.body_offset_yaw": 0.0})))
        commands = _commands(recording, poses, settings.robot.max_speed)
        if recording.format != "odometry":
            _find_body(findings, body, commands, settings)
        settings = settings.with_values({key: findings.values[key] for key in findings.values if key[:6] == "mocap."})
        way = _way(_poses(recording, settings))
        find_motion(findings, way, recording, settings.robot)
        driven = settings.with_values({key: findings.values[key] for key in findings.values if key[:6] == "robot."})
        _find_axes(findings, strokes_of(way, _commands(recording, poses, math.inf)), driven.robot.max_speed)
        if recording.scans:
            _find_mount(findings, recording, way, settings, said)
            if "scan.stamp_offset" not in findings.found and (ahead := _ahead(recording, poses)) > AHEAD:
                del findings.missing["scan.stamp_offset"]
                beyond = max(ahead - 0.5, 0.0)
                findings.found["scan.stamp_offset"] = Found(round(beyond - ahead, 3), round(beyond + 0.1, 3))
    findings.check()
    return findings


def _poses(recording: Recording, settings: Settings) -> list[PoseSample]:
    found, mocap, even = [], settings.mocap, math.nan
    for received, measured in _measured(recording, mocap.subject):
        if mocap.rate > 0.0:
            even = even_stamp(even, received, 1.0 / mocap.rate)
            measured = replace(measured, stamp=even)
        with suppress(PoseError):  # the stages count it
            found.append(robot_pose(measured, received, mocap))
    return found


def _measured(recording: Recording, subject: str) -> Iterator[tuple[float, MeasuredPose]]:
    for received, message in recording.poses:
        with suppress(PoseError):
            measured = FORMATS[recording.format].read(message, subject)
            if measured is not None:
                yield received, measured


def _find_upright(findings: Findings, recording: Recording, settings: Settings) -> dict[str, str]:
    """Adds which axis points up, and returns it where it is found."""
    up = []
    for axes in all_specs()["mocap.axes"].choices:
        poses = _poses(recording, settings.with_values({"mocap.axes": axes}))
        up += [axes] if len(poses) > 2 and is_upright(poses, settings.mocap) else []
    if len(up) != 1:
        findings.missing["mocap.axes"] = TURN
        return {}
    findings.found["mocap.axes"] = Found(up[0])
    return {"mocap.axes": up[0]}


def _find_pose_stream(findings: Findings, poses: list[PoseSample], settings: Settings) -> None:
    stamps = np.array([pose.stamp for pose in poses])
    many = min(100, len(stamps) - 1)
    period = float(np.median(stamps[many:] - stamps[:-many])) / many
    soonest, latest = np.percentile(np.diff(stamps), (5.0, 95.0))
    if soonest < UNEVEN * period and latest - soonest > period:
        findings.found["mocap.rate"] = Found(round(1.0 / period, 1), round(0.05 / period, 1))
    slopes, uncertainty = floor_of(poses)
    if any(pose.height for pose in poses):  # that of an odometry of wheels is no measurement
        if uncertainty <= SLOPE_KNOWN:
            tilt = tuple(round(math.atan(slope), 4) for slope in slopes.tolist())
            findings.found["mocap.floor_tilt"] = Found(tilt, round(uncertainty, 4))
        else:
            findings.missing["mocap.floor_tilt"] = ACROSS
    _remark_stream(findings, stamps, poses, settings)


def _remark_stream(findings: Findings, stamps: np.ndarray, poses: list[PoseSample], settings: Settings) -> None:
    places = np.array([pose.position for pose in poses])
    quality = stream_quality(stamps, stamps, places)
    seconds = [places[k : k + round(quality.rate)] for k in range(0, len(places) - round(quality.rate), 10)]
    noise = float(min((each.std(axis=0).max() for each in seconds), default=math.inf))
    limit, assumed = settings.limits.pose_age, settings.mocap.position_noise
    text = f"poses come up to {1e3 * quality.jitter:.0f} ms unevenly, longest gap {1e3 * quality.longest_gap:.0f} ms"
    if noise < 5.0 * assumed:
        text += f"; noise at rest {1e3 * noise:.2f} mm, mocap.position_noise is {1e3 * assumed:g} mm"
    good = quality.longest_gap < limit and not 2.0 * assumed < noise < 5.0 * assumed
    findings.remarks.append((OK if good else DOUBTFUL, text))


def _commands(recording: Recording, poses: list[PoseSample], largest: float) -> np.ndarray:
    """(m, 4) commands as of `body.asked_at`, as a robot can follow them whose `largest` speed [m/s] is so."""
    late, rows = _lateness(recording, poses), []
    for received, message in recording.commands:
        with suppress(MessageError):
            velocity, yaw_rate = velocity_from_twist(twist_of(message))
            share = min(1.0, largest / max(float(np.hypot(*velocity)), 1e-9))
            rows.append((received - late, *(share * velocity).tolist(), yaw_rate))
    return np.array(rows).reshape(-1, 4)


def _find_body(findings: Findings, body: np.ndarray, commands: np.ndarray, settings: Settings) -> None:
    """Adds the place of the measured body on the robot, from its way."""
    mocap, found = settings.mocap, findings.found
    lever = lever_of(body, commands, settings.robot.velocity_lag)
    strokes = strokes_of(body, commands)
    # of a heading that is told the place is seen by it
    axes = AxesFit(-mocap.body_offset_yaw, 0.0, 1.0, False)
    fit = _fit(strokes, np.zeros(2) if lever is None else lever.lever)
    sure = math.inf if fit is None or fit.mirrored else math.hypot(2.0 * fit.uncertainty, HEADING_FLOOR)
    if fit is not None and sure <= HEADING_KNOWN:
        axes = replace(fit, uncertainty=sure)
        found["mocap.body_offset_yaw"] = Found(round(-fit.turn, 4), round(sure, 4))
    else:
        findings.missing["mocap.body_offset_yaw"] = COMMANDED
    if lever is None or body_offset(axes, lever).position_uncertainty > PLACE_KNOWN:
        findings.missing.update(dict.fromkeys(BODY, BOTH_WAYS))
        return
    offset = body_offset(axes, lever)
    for key, value in zip(BODY, (offset.x, offset.y), strict=True):
        found[key] = Found(round(value, 4), round(offset.position_uncertainty, 4))


def _fit(strokes: list[Stroke], lever: np.ndarray) -> AxesFit | None:
    return fit_axes(strokes, lever) if len(strokes) > 3 else None


def _find_axes(findings: Findings, strokes: list[Stroke], largest: float) -> None:
    """Adds how the robot's way follows the commands; those above its `largest` speed [m/s] show no scale."""
    rests = [Stroke(np.zeros(2), 1.0, each.before, each.before) for each in strokes[:1]]
    # a base that is told to stand stands: so a drive one way alone shows something too
    fit = _fit([*strokes, *rests], np.zeros(2))
    within = _fit([*rests, *(each for each in strokes if np.hypot(*each.velocity) <= largest)], np.zeros(2))
    if fit is None or not math.isfinite(fit.uncertainty):
        return
    asked = np.array([complex(*stroke.velocity.tolist()) for stroke in strokes])
    # along one direction alone, as of a base that cannot go sideways, both explain the same
    sideways = abs((asked**2).sum()) < 0.95 * (np.abs(asked) ** 2).sum()
    turned, mirrored = round(fit.turn, 3), fit.mirrored if sideways else None
    scale = None if within is None else round(within.scale, 3)
    findings.axes.update(turned=turned, mirrored=mirrored, scale=scale)
    far = "as its largest speed allows" if scale is None else f"{scale:.2f} times as far as commanded"
    text = f"moves {far}, turned by {turned:.2f} rad"
    if mirrored:
        findings.remarks.append((WRONG, f"{text}, left is right: mocap.axes, or the order of the wheels"))
    elif abs((scale or 1.0) - 1.0) > 0.1 or abs(turned) > 0.1:
        findings.remarks.append((DOUBTFUL, f"{text}: mocap.units, the radius of the wheels, robot.max_speed"))
    else:
        findings.remarks.append((OK, text))


def _way(poses: list[PoseSample]) -> np.ndarray:
    """(n, 4) rising stamp [s], x, y [m] and yaw, not wrapped [rad]; without the values that a moving robot repeats."""
    rows = np.array([(pose.stamp, *pose.position.tolist(), pose.yaw) for pose in poses])
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    rows = rows[np.r_[True, np.diff(rows[:, 0]) > 0.0]]
    new = np.r_[True, np.any(np.diff(rows[:, 1:], axis=0) != 0.0, axis=1)]
    starts = np.flatnonzero(new)
    rests = np.diff(rows[starts, 0], append=rows[-1, 0]) > RESTS
    rows[:, 3] = np.unwrap(rows[:, 3])
    return rows[new | np.repeat(rests, np.diff(starts, append=len(rows)))]


def scans_of(recording: Recording, settings: Settings) -> list[Scan]:
    """Those that can be read, of one number of beams, with no mount and no stamp told, in the order of their stamps."""
    told = {"scan.stamp_offset": 0.0, "scan.backwards": False, "scan.instant": False}
    taken = settings.with_values(told | {"scan.zero": "near", "scan.infinite": "free"}).scan
    scans = []
    for _, message in recording.scans:
        with suppress(ScanError):
            scans.append(scan_from_message(message, settings.frames.base, taken))
    return sorted((scan for scan in scans if len(scan.ranges) == len(scans[0].ranges)), key=lambda scan: scan.stamp)


def driven_of(scans: list[Scan], way: np.ndarray, masked: tuple[float, ...]) -> tuple[Driven, np.ndarray]:
    """The drive as arrays, and (m, k) the ranges as the messages give them, NaN where masked."""
    first, step = scans[0], math.ceil(len(scans[0].ranges) / BEAMS)
    raw = np.array([scan.ranges[::step] for scan in scans])
    raw[:, is_masked(first.angles[::step], masked)] = math.nan
    ranges = np.where(np.isfinite(raw) & (raw < FARTHEST), raw, math.nan)
    stamps = np.array([scan.stamp for scan in scans])
    poses, between = np.ascontiguousarray(way[:, 1:]), first.time_increment * step
    return Driven(way[:, 0], poses, stamps, ranges, first.angles[::step], between), raw


def _find_mount(
    findings: Findings, recording: Recording, way: np.ndarray, settings: Settings, said: Callable[[float], None]
) -> None:
    scans, scan = scans_of(recording, settings), settings.scan
    fit = None
    if scans and len(way) > 1:
        posts = own_posts(scans, way)
        if posts is None:
            findings.missing["scan.masked_angles"] = TURN
        elif posts:
            findings.found["scan.masked_angles"] = Found(posts, round(2.0 * abs(scans[0].angle_increment), 4))
        driven, raw = driven_of(scans, way, posts or scan.masked_angles)
        fit = fit_mount(driven, 0 if scan.instant else -1 if scan.backwards else 1, said)
    if fit is None or not fit.clear:
        findings.missing.update(dict.fromkeys((*MOUNT, "scan.mirrored", "scan.backwards"), f"{TURN}, and {WAY}"))
        return
    _take_fit(findings, fit)
    for key, code in (("scan.zero", -math.inf), ("scan.infinite", math.inf)) if fit.known.all() else ():
        meaning = meaning_of(code, raw, driven, fit.mount, (scans[0].range_min, scans[0].range_max))
        if meaning:
            findings.found[key] = Found(meaning)
        else:
            findings.missing[key] = OPEN


def _take_fit(findings: Findings, fit: MountFit) -> None:
    mount, of_body = fit.mount, (findings.found.get(key) for key in (BODY[0], *BODY, "mocap.body_offset_yaw"))
    # what is wrong in the body's place is wrong in the LIDAR's
    shared = [0.0 if each is None else each.uncertainty or 0.0 for each in of_body]
    uncertainty = np.hypot(fit.uncertainty, [0.0, *shared[1:]]).tolist()
    for k, (key, value) in enumerate(zip(MOUNT, (mount.late, mount.x, mount.y, mount.yaw), strict=True)):
        if fit.known[k]:
            findings.found[key] = Found(round(value, 4), round(uncertainty[k], 4))
        else:
            findings.missing[key] = WAY if key == "scan.offset_yaw" else TURN
    if fit.known[3]:
        findings.found["scan.mirrored"] = Found(mount.mirrored)
    if fit.sweep_known:
        findings.found["scan.backwards"] = Found(mount.sweep < 0)
        findings.found["scan.instant"] = Found(mount.sweep == 0)
    else:
        findings.missing["scan.backwards"] = TURN


def _ahead(recording: Recording, poses: list[PoseSample]) -> float:
    """Time by which the scans' stamps are ahead of the poses', by when both were received [s]."""
    late = [received - seconds_from_stamp(message.header.stamp) for received, message in recording.scans]
    return _lateness(recording, poses) - float(np.median(late))


def _lateness(recording: Recording, poses: list[PoseSample]) -> float:
    """Time from the poses' stamps until they are received [s]."""
    return float(np.median([at for at, _ in recording.poses[: len(poses)]] - np.array([pose.stamp for pose in poses])))
