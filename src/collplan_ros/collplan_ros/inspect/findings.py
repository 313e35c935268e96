"""What a recording shows of the parameters: each value found with its uncertainty, and what the motion did not show."""

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np

from collplan_core.mounting.driven import Driven
from collplan_core.mounting.fit import MountFit, fit_mount
from collplan_core.parameters import Mocap, Robot, Settings, all_specs
from collplan_core.parameters.spec import ParameterError
from collplan_core.scan import ScanError
from collplan_core.sensing.mocap_body import MeasuredPose, robot_pose
from collplan_core.sensing.pose_filter import PoseError, PoseSample
from collplan_ros.inspect.recording import Recording
from collplan_ros.inspect.stages import Stages
from collplan_ros.messages.mocap_formats import FORMATS
from collplan_ros.messages.reading import scan_from_message, seconds_from_stamp, twist_of

BEAMS, FARTHEST = 360, 8.0
"""Beams of a scan that are compared at most, and the farthest range [m]."""
AHEAD = 0.05
"""Time by which scans may come before their stamps, as poses come, by the noise of receipt [s]."""
UNEVEN = 0.5
"""Share of the period so soon after the last pose that none is measured: those were stamped at receipt."""
STEP = 0.05
"""Speeds are taken over two such steps, and accelerations over six [s]."""
STAYS = 5.0
"""Time at the largest speed shown, while commands ask for more, from which on it is the robot's largest [s]."""
BEYOND = 1.3
"""Multiple of what is set from which on a speed or acceleration is another: the noise of poses makes less."""
RESTS = 0.25
"""A value repeated for longer is a robot at rest; for less it was not measured again [s]."""
TURN, WAY = "turn once at about 1 rad/s", "drive 2 m straight on"
MOUNT = ("scan.stamp_offset", "scan.offset_x", "scan.offset_y", "scan.offset_yaw")


@dataclass(frozen=True)
class Found:
    """A value of a parameter, and within what the truth lies in 95 of 100; None where it is a name or a choice."""

    value: Any
    uncertainty: float | None = None


@dataclass(frozen=True, eq=False)
class Findings:
    """Parameters found, and those that the motion did not show, each with the motion that would."""

    found: dict[str, Found] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)

    @property
    def values(self) -> dict[str, Any]:
        """The values alone."""
        return {key: each.value for key, each in self.found.items()}


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
    findings, poses = Findings(wiring(recording, settings.mocap.subject)), _poses(recording, settings)
    if len(poses) > 2:
        way = _way(poses)
        _find_pose_stream(findings, poses, settings.mocap)
        _find_motion(findings, way, recording, settings.robot)
        if recording.scans:
            _find_mount(findings, recording, way, settings, said)
            if "scan.stamp_offset" not in findings.found and (ahead := _ahead(recording, poses)) > AHEAD:
                del findings.missing["scan.stamp_offset"]
                beyond = max(ahead - 0.5, 0.0)
                findings.found["scan.stamp_offset"] = Found(round(beyond - ahead, 3), round(beyond + 0.1, 3))
    for key, each in list(findings.found.items()):
        try:
            all_specs()[key].checked(each.value)
        except ParameterError as error:
            del findings.found[key]
            findings.missing[key] = str(error)
    return findings


def _poses(recording: Recording, settings: Settings) -> list[PoseSample]:
    found = []
    for received, measured in _measured(recording, settings.mocap.subject):
        with suppress(PoseError):  # the stages count it
            found.append(robot_pose(measured, received, settings.mocap))
    return found


def _measured(recording: Recording, subject: str) -> Iterator[tuple[float, MeasuredPose]]:
    for received, message in recording.poses:
        with suppress(PoseError):
            measured = FORMATS[recording.format].read(message, subject)
            if measured is not None:
                yield received, measured


def _find_pose_stream(findings: Findings, poses: list[PoseSample], mocap: Mocap) -> None:
    stamps, heights = np.array([pose.stamp for pose in poses]), np.array([pose.height for pose in poses])
    many = min(100, len(stamps) - 1)
    period = float(np.median(stamps[many:] - stamps[:-many])) / many
    soonest, latest = np.percentile(np.diff(stamps), (5.0, 95.0))
    if soonest < UNEVEN * period and latest - soonest > period:
        findings.found["mocap.rate"] = Found(round(1.0 / period, 1), round(0.05 / period, 1))
    level = np.percentile(np.abs(heights - heights[0]), 99.0)
    if level > mocap.max_lift:
        places = np.array([(*pose.position.tolist(), 1.0) for pose in poses])
        plane = np.linalg.lstsq(places, heights, rcond=None)[0]
        if np.percentile(np.abs(heights - places @ plane), 99.0) < 0.5 * mocap.max_lift:
            # the floor is a plane that is tilted in the axes: its whole rise is no lift
            findings.found["mocap.max_lift"] = Found(round(1.3 * float(level) + mocap.max_lift, 3))


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


def _find_motion(findings: Findings, way: np.ndarray, recording: Recording, robot: Robot) -> None:
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
    twists = [twist_of(message).linear for _, message in recording.commands]
    asked = max((math.hypot(each.x, each.y) for each in twists), default=0.0)
    if shown > BEYOND * robot.max_speed or (stays and asked > 1.2 * shown > 0.1):
        findings.found["robot.max_speed"] = Found(round(1.05 * shown, 3), round(0.1 * shown, 3))
    else:
        findings.missing["robot.max_speed"] = "record commands, and drive at full speed for 2 s"
    # a bump is over sooner than the wheels accelerate: each third of a change must have its part
    changes = velocities[6:] - velocities[:-6]
    along = changes / np.maximum(np.hypot(*changes.T), 1e-9)[:, None]
    thirds = [
        ((velocities[k + 2 : len(velocities) - 4 + k] - velocities[k : k - 6]) * along).sum(axis=1) for k in (0, 2, 4)
    ]
    sustained = float(np.min(thirds, axis=0).max()) / (2.0 * STEP)
    if sustained > BEYOND * robot.max_acceleration:
        findings.found["robot.max_acceleration"] = Found(round(1.1 * sustained, 2), round(0.2 * sustained, 2))


def driven_of(recording: Recording, way: np.ndarray, settings: Settings) -> Driven | None:
    """The drive as arrays, its scans read with no mount and no stamp told; None without scans that can be read."""
    scans = []
    taken = settings.with_values({"scan.stamp_offset": 0.0, "scan.backwards": False, "scan.instant": False}).scan
    for _, message in recording.scans:
        with suppress(ScanError):
            scans.append(scan_from_message(message, settings.frames.base, taken))
    scans = sorted((scan for scan in scans if len(scan.ranges) == len(scans[0].ranges)), key=lambda scan: scan.stamp)
    if not scans or len(way) < 2:
        return None
    first, step = scans[0], math.ceil(len(scans[0].ranges) / BEAMS)
    ranges = np.array([scan.ranges[::step] for scan in scans])
    ranges = np.where(np.isfinite(ranges) & (ranges > 0.0) & (ranges < FARTHEST), ranges, np.nan)
    stamps = np.array([scan.stamp for scan in scans])
    return Driven(
        way[:, 0], np.ascontiguousarray(way[:, 1:]), stamps, ranges, first.angles[::step], first.time_increment * step
    )


def _find_mount(
    findings: Findings, recording: Recording, way: np.ndarray, settings: Settings, said: Callable[[float], None]
) -> None:
    driven, scan = driven_of(recording, way, settings), settings.scan
    given = 0 if scan.instant else -1 if scan.backwards else 1
    fit = None if driven is None else fit_mount(driven, given, said)
    if fit is None or not fit.clear:
        findings.missing.update(dict.fromkeys((*MOUNT, "scan.mirrored", "scan.backwards"), f"{TURN}, and {WAY}"))
    else:
        _take_fit(findings, fit)


def _take_fit(findings: Findings, fit: MountFit) -> None:
    mount, uncertainty = fit.mount, fit.uncertainty.tolist()
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
    pose_late = np.median([at for at, _ in recording.poses[: len(poses)]] - np.array([pose.stamp for pose in poses]))
    return float(pose_late - np.median(late))


def axes_of(stages: Stages) -> dict[str, Any]:
    """How the motion measured is turned [rad], mirrored and scaled against the commands; None where not shown."""
    nothing = {"turned": None, "mirrored": None, "scale": None}
    moving = [(state, wanted) for state, wanted in stages.moves if np.hypot(*wanted) > 0.05]
    if len(moving) < 40:
        return nothing
    measured = np.array([complex(*state.velocity) * np.exp(-1j * state.yaw) for state, _ in moving])
    asked = np.array([complex(*wanted) for _, wanted in moving])
    straight, mirror = measured @ asked.conj(), measured @ asked
    # along one direction alone, as of a base that cannot go sideways, both explain the same
    sideways = abs((asked**2).sum()) < 0.95 * (np.abs(asked) ** 2).sum()
    mirrored = bool(abs(mirror) > abs(straight)) if sideways else None
    best = mirror if mirrored else straight
    scale = abs(best) / float((np.abs(asked) ** 2).sum())
    return {"turned": round(float(np.angle(best)), 3), "mirrored": mirrored, "scale": round(scale, 3)}
