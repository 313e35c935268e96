"""What the stages of the robot's own nodes would have said of a recording: poses, scans, movers, motion."""

import math
import re
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from collplan_core.command import FREE_SPACE, Command
from collplan_core.control.interlock import LONGEST_FAULT
from collplan_core.control.motion_monitor import LATE, REVERSED, SLIP
from collplan_core.impact import Impact
from collplan_core.loop.drive_watch import NEARBY, DriveWatch
from collplan_core.loop.input_gate import InputGate, Refusals
from collplan_core.loop.motion_watch import MotionWatch
from collplan_core.loop.sensed_scans import SensedScans
from collplan_core.parameters import Settings
from collplan_core.poses.mocap_body import MeasuredPose, even_stamp, robot_pose
from collplan_core.poses.pose_filter import FRESH, PoseError, filter_pose
from collplan_core.scan import Scan, ScanError
from collplan_ros.inspect.body import COMMAND_LASTS
from collplan_ros.inspect.recording import Recording
from collplan_ros.messages.mocap_formats import FORMATS
from collplan_ros.messages.reading import MessageError, scan_from_message, twist_of, velocity_from_twist

TICK = 0.05
"""Period at which the inputs are looked at [s]."""
RESTS = 0.03
"""Speed below which a robot that is told to stand is at rest [m/s]."""
NUMBER = re.compile(r"\d+(\.\d+)?")
Happened = tuple[float, str, tuple[Any, ...]]
"""Time of receipt [s] of what made something happen, the method of `Drawing` that shows that, and its arguments."""


class Reasons(Refusals):
    """Refused inputs counted by reason, without the numbers in it, and the most in a row."""

    def __init__(self) -> None:
        super().__init__()
        self.counts: Counter[str] = Counter()
        self.in_a_row = self.longest = 0

    def add(self, kind: str, reason: str) -> None:
        """Counts a refused scan; a break of the poses is none."""
        super().add(kind, reason)
        if kind == "scan":
            self.counts[NUMBER.sub("#", reason.split(":")[0])] += 1
            self.in_a_row += 1
            self.longest = max(self.longest, self.in_a_row)


class Stages:
    """Poses, scans and commands pass the stages one by one, each at its time of receipt [s]."""

    def __init__(self, recording: Recording, settings: Settings) -> None:
        """Nothing has come yet."""
        self.impacts: list[Impact] = []  # found in the poses
        self.drive = DriveWatch(settings)  # as learnt from the commands
        self.happened: list[Happened] = []  # all that a page can show, in order
        self._settings, self._memory = settings, FRESH
        self._read = FORMATS[recording.format].read
        self._sensed, self._reasons = SensedScans(settings.limits.pose_history), Reasons()
        self._gate, self._watch = InputGate(self._sensed, self._reasons), MotionWatch()
        self._newest: MeasuredPose | None = None
        self._scan: Scan | None = None
        self._told, self._why = 0, ""
        self._even, self._seen, self._judged = math.nan, math.nan, math.inf
        self._refused_poses: Counter[str] = Counter()
        self._verdicts: Counter[str] = Counter()
        self._poses = self._scans = self._held = self._with_mover = 0
        self._stopped = self._standing = self._fastest = self._mover_speed = 0.0
        self._command: tuple[float, np.ndarray, float] = (-math.inf, np.zeros(2), 0.0)
        self._tracks: set[int] = set()

    def take_pose(self, received: float, message: Any) -> None:
        """Takes a message of the motion capture or odometry, as mocap_node does."""
        mocap = self._settings.mocap
        try:
            measured = self._read(message, mocap.subject)
            if measured is None:
                return
            if mocap.rate > 0.0:
                self._even = even_stamp(self._even, received, 1.0 / mocap.rate)
                measured = replace(measured, stamp=self._even)
            repeats, self._newest = measured.repeats(self._newest), measured
            if repeats and not (mocap.accept_frozen or mocap.format == "odometry"):
                return
            self._poses += 1
            sample = robot_pose(measured, received, mocap)
        except PoseError as error:
            self._refuse_pose(received, error.reason, None)
            return
        result, self._memory = filter_pose(self._memory, sample, received, self._settings)
        if result.impact is not None:
            self._take_impact(received, result.impact)
        if result.refused:
            self._refuse_pose(received, result.refused, sample.position)
        elif result.state is not None:
            self._fastest = max(self._fastest, result.speed)
            self.happened.append((received, "pose", (result.state,)))
            joins = self._gate.take_pose(result.state, received, self._settings)
            self._watch.take_pose(result.state, received, joins, self._settings, self._sensed.movers)
            self.drive.take_pose(self._watch.drive, joins, self._watch.pushed)
            self._look_at_scans(received)

    def _take_impact(self, received: float, impact: Impact) -> None:
        self.impacts.append(impact)
        self.happened.append((received, "impact", (impact,)))
        state, reach = self._gate.state, self._settings.robot.radius + NEARBY
        self.drive.take_impact(impact.time, impact.change, state is not None and self._watch.is_near(state, reach))

    def _refuse_pose(self, received: float, reason: str, at: np.ndarray | None) -> None:
        self._refused_poses[reason] += 1
        self.drive.refuse_pose()
        self._gate.refuse("pose", reason)
        self.happened.append((received, "refused_pose", (reason, at)))

    def take_scan(self, received: float, message: Any) -> None:
        """Takes a LaserScan, as planner and controller do."""
        self._scans += 1
        try:
            scan = scan_from_message(message, self._settings.frames.base, self._settings.scan)
        except ScanError as error:
            self._reasons.add("scan", str(error))
            self._gate.refuse("scan", str(error))
        else:
            self._scan = scan
            self._gate.take_scan(scan, received, self._settings)
        self._look_at_scans(received)
        self._watch.take_scan(self._sensed.newest_placed(), self._settings)

    def _look_at_scans(self, received: float) -> None:
        placed, movers = self._sensed.newest_placed(), self._sensed.movers
        if self._reasons["scan"] > self._told:
            self._told = self._reasons["scan"]
            at = None if self._scan is None else self._sensed.pose_at(self._scan.stamp)
            self.happened.append((received, "refused_scan", (self._reasons.newest, self._scan, at)))
        if placed is None or placed[0].stamp == self._seen:
            return
        self._seen, self._reasons.in_a_row = placed[0].stamp, 0
        self._tracks |= set(movers.numbers.tolist())
        self._with_mover += len(movers) > 0
        self.happened.append((received, "scan", (*placed, movers)))
        self._mover_speed = max(self._mover_speed, float(np.hypot(*movers.velocities.T).max(initial=0.0)))

    def take_command(self, received: float, message: Any) -> None:
        """Takes a command to the base."""
        try:
            self._command = (received, *velocity_from_twist(twist_of(message)))
        except MessageError:
            return
        self._judge(received)

    def _judge(self, local: float) -> None:
        """Judges the motion up to now, as in each period of the controller, and the command that holds from now on."""
        settings, (sent, velocity, yaw_rate) = self._settings, self._command
        still, size = local - sent > COMMAND_LASTS, float(np.hypot(*velocity))
        wanted = np.zeros(2) if still else velocity * min(1.0, settings.robot.max_speed / max(size, 1e-9))
        self._watch.judge(local, settings)
        self._verdicts[self._watch.verdict.kind] += 1
        command = Command(wanted, 0.0 if still else yaw_rate, FREE_SPACE, np.zeros(2))
        self._watch.commanded(command, local)
        if math.isfinite(sent):
            # the learner takes a robot at rest, whose wheels err by nothing, for one that follows commands slowly
            state = self._gate.state
            rests = not wanted.any() and state is not None and float(np.hypot(*state.velocity)) < RESTS
            self.drive.commanded(command, self._gate.now(local), self._watch.verdict.kind, "at rest" if rests else "")
        self._judged = local

    def tick(self, local: float) -> None:
        """Looks whether the robot would have had to stand; where no command has come, the last one holds."""
        settings = self._settings
        if local - self._judged >= TICK:
            self._judge(local)
        why = self._gate.why_lost(local, settings.limits)
        if why != self._why:
            self._why = why
            self.happened.append((local, "stands", (why,)))
        if why:
            before, self._standing = self._standing, self._standing + TICK
            self._stopped += TICK
            self._held += before <= LONGEST_FAULT < self._standing
        else:
            self._standing = 0.0

    def report(self, duration: float) -> dict[str, Any]:
        """What was said, with the keys of `inspect.json`."""
        refused = sum(self._refused_poses.values())
        return {
            "poses": {
                "n": self._poses,
                "rate_hz": round(self._poses / duration, 2),
                "refused": refused,
                "reasons": dict(self._refused_poses),
                "impacts": len(self.impacts),
                "largest_speed": round(self._fastest, 3),
            },
            "scans": {
                "n": self._scans,
                "rate_hz": round(self._scans / duration, 2),
                "refused": self._reasons["scan"],
                "reasons": dict(self._reasons.counts),
                "longest_refused": self._reasons.longest,
                "stopped_s": round(self._stopped, 2),
                "held": self._held,
            },
            "movers": {
                "tracks": len(self._tracks),
                "scans_with_mover": self._with_mover,
                "largest_speed": round(self._mover_speed, 2),
            },
            "motion": {kind: self._verdicts[kind] for kind in (LATE, REVERSED, SLIP)},
        }


def passed_through(recording: Recording, settings: Settings, said: Callable[[float], None]) -> Stages:
    """Passes a whole recording through the stages in the order of receipt; `said` takes the share that is done."""
    stages = Stages(recording, settings)
    takes = stages.take_pose, stages.take_scan, stages.take_command
    rows = recording.poses, recording.scans, recording.commands
    # at one instant poses come first
    events = sorted(
        ((at, kind, message) for kind, row in enumerate(rows) for at, message in row), key=lambda event: event[:2]
    )
    tick = events[0][0] + TICK
    for count, (at, kind, message) in enumerate(events):
        while tick < at:
            stages.tick(tick)
            tick += TICK
        takes[kind](at, message)
        if count % 500 == 0:
            said(count / len(events))
    return stages
