"""The findings of a recording in words: what is right, doubtful or wrong, and what to do."""

from collections.abc import Iterator, Mapping
from typing import Any

from collplan_ros.inspect.found import DOUBTFUL, OK, WRONG, Findings

MENDED = "mended"
MOST_REFUSED = 0.01
"""Share of poses or scans refused beyond which something is wrong."""
LEAST_RATE = 15.0
"""Rate of poses below which the robot cannot be driven [Hz]."""
MOST_MISFIT = 20
"""Periods of 50 ms in which the motion may not fit the commands."""
Line = tuple[str, str]
ELSE = "see docs/troubleshooting.md"
SCAN_REMEDIES = {
    "same to the last bit": "the driver repeats scans: publish one for each turn of the LIDAR",
    "missing": "the odometry, its stamps or the LIDAR's place are wrong: record a drive with turns and straight ways",
    "was seen": "the stamps are late, or beams are reversed: record a turn",
    "its stamp": "the clocks of LIDAR and poses differ, or messages are delayed: synchronise them",
    "lost": "too many beams measure nothing: scan.infinite, scan.zero?",
    "angle_max": "beams and angles do not fit: the driver is wrong",
}
REMEDIES = {
    "frame": "set mocap.frame",
    "height": "the axes are tilted or the robot was lifted: mocap.axes, mocap.floor_tilt",
    "tilt": "does the body's z axis point up: mocap.axes?",
    "speed": "is it faster than robot.max_speed, or does the receiver stamp at receipt: mocap.rate?",
    "leap": "is it one body: mocap.subject, mocap.units, robot.max_speed?",
    "yaw": "are the markers nearly symmetric?",
    "stamp": "do two receivers publish on this topic?",
}


def lines_of(as_set: Mapping[str, Any], as_found: Mapping[str, Any], findings: Findings) -> Iterator[Line]:
    """Yields a verdict and a sentence on each thing; a verdict WRONG is one that the values found do not mend."""
    for before, after in zip(_stage_lines(as_set), _stage_lines(as_found), strict=True):
        if before[0] != OK and after[0] == OK:
            yield MENDED, f"{before[1]}; with found.yaml: {after[1]}"
        else:
            yield after
    yield from findings.remarks
    by_motion: dict[str, list[str]] = {}
    for key, motion in findings.missing.items():
        by_motion.setdefault(motion, []).append(key)
    for motion, keys in by_motion.items():
        yield DOUBTFUL, f"not shown by this recording: {', '.join(keys)}. To show it: {motion}"


def _stage_lines(said: Mapping[str, Any]) -> list[Line]:
    return [_poses(said["poses"]), _impacts(said["poses"]), _scans(said["scans"]), _motion(said["motion"])]


def _poses(poses: Mapping[str, Any]) -> Line:
    if not poses["n"]:
        return WRONG, "no pose: record the topic of the motion capture or odometry, or name it by --poses"
    text = f"{poses['n']} poses at {poses['rate_hz']:.0f} Hz, {_refused(poses)}"
    if poses["refused"] > MOST_REFUSED * poses["n"]:
        worst = max(poses["reasons"], key=poses["reasons"].get)
        return WRONG, f"{text}: {REMEDIES.get(worst, ELSE)}"
    if poses["rate_hz"] < LEAST_RATE:
        return WRONG, f"{text}, expected at least {LEAST_RATE:g} Hz"
    return OK, text


def _impacts(poses: Mapping[str, Any]) -> Line:
    text = f"{poses['impacts']} impacts, largest speed {poses['largest_speed']:.2f} m/s"
    if not poses["impacts"]:
        return OK, text
    return DOUBTFUL, f"{text}: where nothing was hit, robot.max_acceleration is less than it brakes with"


def _scans(scans: Mapping[str, Any]) -> Line:
    if not scans["n"]:
        return DOUBTFUL, "no scan: without a LIDAR the robot cannot be driven; or name the topic by --scans"
    text = f"{scans['n']} scans at {scans['rate_hz']:.1f} Hz, {_refused(scans)}, longest {scans['longest_refused']}"
    text += f"; the robot would stand for {scans['stopped_s']:.1f} s and be held {scans['held']} times"
    if scans["refused"] > MOST_REFUSED * scans["n"] or scans["held"]:
        worst = max(scans["reasons"], key=scans["reasons"].get, default="")
        return WRONG, f"{text}: {next((what for part, what in SCAN_REMEDIES.items() if part in worst), ELSE)}"
    return OK, text


def _motion(motion: Mapping[str, int]) -> Line:
    found = ", ".join(f"{kind} in {count}" for kind, count in motion.items() if count)
    if not found:
        return OK, "the motion fits the commands, as far as any were recorded"
    text = f"motion {found} periods of 50 ms: robot.max_speed, mocap.body_offset_yaw?"
    return (DOUBTFUL if max(motion.values()) > MOST_MISFIT else OK), text


def _refused(counts: Mapping[str, Any]) -> str:
    reasons = ", ".join(f"{count} of {reason}" for reason, count in counts["reasons"].items())
    return f"{counts['refused']} refused" + (f" ({reasons})" if reasons else "")
