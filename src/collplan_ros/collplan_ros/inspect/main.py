"""The program inspect: reads a recording of any robot, and writes the parameters that it shows."""

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from datetime import datetime
from importlib import import_module
from pathlib import Path
from typing import Any

from tqdm import tqdm

from collplan_core.calibration.frame_chain import mount_in
from collplan_core.command_line import parser_of
from collplan_core.parameters import Settings
from collplan_core.parameters.file import read_parameters, write_values
from collplan_core.parameters.spec import ParameterError
from collplan_ros.inspect.driving import find_driven
from collplan_ros.inspect.findings import find, wiring
from collplan_ros.inspect.found import Findings
from collplan_ros.inspect.page import PAGE, write_inspect_page
from collplan_ros.inspect.recording import Recording, RecordingError, Topics, read_recording
from collplan_ros.inspect.stages import Stages, passed_through
from collplan_ros.inspect.words import DOUBTFUL, WRONG, lines_of
from collplan_ros.run.whole_file import RecordError

GOOD, NOT_MENDED, UNREADABLE = 0, 1, 2
"""Exit codes: nothing is wrong with found.yaml, something still is, and nothing could be read."""
DESCRIPTION = """\
Reads a recording of a robot that somebody drove, tells what is wrong with its poses, scans and motion, and writes
found.yaml, a parameter file with what the recording shows of the sensors, inspect.json, and inspect.html, which plays
the recording in a browser. RECORDING is a ROS 1 bag, a ROS 2 bag (folder, .mcap or .db3), or a run folder of bringup;
to read it needs neither ROS nor the robot.

Nothing is wrong, or found.yaml mends it: exit code 0. Something else is wrong: 1. Unreadable: 2.
"""
EPILOG = """\
examples:
  inspect drive.mcap                            topics found by type and rate
  inspect drive --scans /front/scan             one of several LIDARs
  inspect runs/latest --params lab.yaml         what lab.yaml would have said of a run
  inspect --live 60 --out found                 records for a minute, then the same
"""


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    parser = _parser()
    options = parser.parse_args(args)
    if (options.recording is None) == (options.live is None):
        parser.error("expected either RECORDING or --live")
    topics = Topics(options.poses, options.scans, options.commands)
    try:
        given = read_parameters(options.params) if options.params else {}
        path = options.recording or _recorded(options.live, options.out)
        recording = read_recording(path, topics, Settings().with_values(given).mocap, _bar("reading"))
        options.out.mkdir(parents=True, exist_ok=True)
        return _inspect(recording, given, options.out)
    except (RecordingError, RecordError, ParameterError, OSError) as error:
        print(f"inspect: {error}", file=sys.stderr)
        return UNREADABLE


def _parser() -> argparse.ArgumentParser:
    parser = parser_of("inspect", DESCRIPTION, EPILOG)
    add = parser.add_argument
    add("recording", type=Path, nargs="?", metavar="RECORDING", help="bag, or run folder")
    live = "record the robot's topics for so long while somebody drives it by hand, then inspect that; needs ROS"
    add("--live", type=float, metavar="SECONDS", help=live)
    add("--params", type=Path, metavar="FILE", help="parameters to begin with, also in found.yaml; else those shipped")
    add("--out", type=Path, default=Path(), metavar="DIR", help="folder of what is written (default: this one)")
    add("--poses", default="", metavar="TOPIC", help="topic of the poses, where there are several")
    add("--scans", default="", metavar="TOPIC", help="topic of the scans")
    add("--commands", default="", metavar="TOPIC", help="topic of the commands to the base")
    return parser


def _recorded(duration: float, out: Path) -> Path:
    """The file that the robot's topics were recorded into."""
    try:
        live = import_module("collplan_ros.inspect.live")
    except ImportError as error:  # all else works without ROS
        raise RecordingError(f"--live: needs ROS: {error}") from None
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"drive_{datetime.now():%Y%m%d_%H%M%S}.mcap"
    print(f"recording {path}; drive the robot by hand, Ctrl-C ends it", flush=True)
    live.record_live(path, duration, _bar("listening"))
    return path


def _inspect(recording: Recording, given: dict[str, Any], out: Path) -> int:
    settings = Settings().with_values(_placed(recording, given))
    before = passed_through(recording, settings, _bar("as set"))
    findings = find(recording, settings, _bar("fitting"))
    settings = settings.with_values(findings.values)
    after = passed_through(recording, settings, _bar("as found"))
    find_driven(findings, recording, after)
    report = _report(recording, before, after, findings)
    (out / "inspect.json").write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    write_values(given | findings.values, out / "found.yaml", _comment(findings))
    cut_off = DOUBTFUL, f"the recording is cut off: this is of its first {recording.duration:.1f} s"
    lines = [cut_off] if recording.is_cut else []
    lines += lines_of(report["as_set"], report["as_found"], findings)
    for verdict, text in lines:
        print(f"{verdict:>8}  {text}")
    write_inspect_page(out / PAGE, recording.name, after.happened, settings, lines)
    print(f"written to {out / 'found.yaml'}, inspect.json and {PAGE}")
    return NOT_MENDED if any(verdict == WRONG for verdict, _ in lines) else GOOD


def _placed(recording: Recording, given: dict[str, Any]) -> dict[str, Any]:
    """The parameters given, with what bringup takes from the graph: topics, and the LIDAR's place on /tf_static."""
    subject = Settings().with_values(given).mocap.subject
    values = given | {key: each.value for key, each in wiring(recording, subject).items()}
    if "scan.frame" not in values or any(key.startswith("scan.offset_") for key in given):
        return values
    try:
        mount = mount_in(recording.links, Settings().with_values(given).frames.base, values["scan.frame"])
    except ValueError:  # not level: the fit says more
        mount = None
    if mount is None:
        return values
    place = {f"scan.offset_{key}": getattr(mount, key) for key in ("x", "y", "yaw")}
    return values | place | {"scan.mirrored": mount.mirrored}


def _report(recording: Recording, before: Stages, after: Stages, findings: Findings) -> dict[str, Any]:
    return {
        "as_set": before.report(recording.duration),
        "as_found": after.report(recording.duration),
        "found": {key: {"value": each.value, "uncertainty": each.uncertainty} for key, each in findings.found.items()},
        "missing": list(findings.missing),
        "axes": findings.axes,
    }


def _comment(findings: Findings) -> str:
    sure = [f"{key}: within {each.uncertainty:g}" for key, each in findings.found.items() if each.uncertainty]
    unseen = [f"not shown: {key}; {motion}" for key, motion in findings.missing.items()]
    return "\n".join(["Found by inspect, of 100 values 95 are as sure as this:", *sure, *unseen])


def _bar(what: str) -> Callable[[float], None]:
    """A progress bar on a terminal, which takes the share done."""
    bar = tqdm(total=1.0, desc=what, leave=False, disable=None, bar_format="{desc:>9} {bar} {percentage:3.0f} %")

    def show(share: float) -> None:
        bar.update(share - bar.n)

    return show


if __name__ == "__main__":
    sys.exit(main())
