"""`bringup --check`: link, motion capture and axes of a robot before it drives by itself; finds the body's offset.

With --scan real and a world file it finds where the LIDAR is, too. Only the robot and mocap_node run. The check drives
slowly, in open loop, and asks before it does.
"""

import math
import select
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from math import degrees

import numpy as np

from collplan_core.calibration import body_motions
from collplan_core.calibration.body_motions import MOST_DISTANCE, MotionEstimate, Motions, estimate
from collplan_core.calibration.mocap_offset import BodyOffset
from collplan_core.calibration.stream_quality import stream_quality
from collplan_core.parameters.file import read_parameters, write_values
from collplan_core.worlds import has_room
from collplan_ros.bringup import check_findings as findings
from collplan_ros.bringup.check_findings import WRONG, Finding
from collplan_ros.bringup.driving import refuse_kept_stop, wait_until_poses_come
from collplan_ros.bringup.failures import FOUND_WRONG, GraphError, Interrupted, StartError
from collplan_ros.bringup.graph import Graph
from collplan_ros.bringup.lidar_scans import LidarScans
from collplan_ros.bringup.open_loop import InterruptedTooOften, OpenLoop
from collplan_ros.bringup.options import REAL, Options
from collplan_ros.bringup.preparation import FLOOR, Preparation, prepare
from collplan_ros.bringup.progress import Progress
from collplan_ros.bringup.run_folder import RunFolder

NOT_NEEDED = ("lidar_node", "planner_node", "controller_node")
REPORT_PATIENCE = 10.0
"""Longest wait for a report of every node [s]; each sends one a second."""
WATCHING_TIME = 2.0
"""Time for which poses of the robot at rest are recorded [s]."""


class Declined(RuntimeError):
    """The user did not agree to a motion of the robot."""

    exit_code = FOUND_WRONG


class FoundWrong(RuntimeError):
    """Error of a check whose finding was already printed."""


def check(options: Options, progress: Progress) -> int:
    """Runs the whole check; returns an exit code, 0 where nothing is wrong.

    Raises:
        StartError: the request cannot be fulfilled; nothing was started.
    """
    if not options.yes and not (sys.stdin and sys.stdin.isatty()):
        raise StartError("--check: asks before it moves the robot, so it needs a terminal, or --yes")
    preparation = _prepared(options)
    given = read_parameters(options.params, options.graph) if options.params else {}
    folder = RunFolder(options.out, preparation.settings)
    try:
        with Graph(preparation, folder, progress) as graph:
            if options.scan == REAL and not options.world:
                progress.say("without --world the LIDAR's mounting pose is not determined")
            lidar = LidarScans(graph.listener, preparation) if options.scan == REAL and options.world else None
            found, passed = Check(graph, options.yes, lidar).run()
    except StartError:
        folder.discard()
        raise
    except (Declined, Interrupted, GraphError) as error:
        progress.say(str(error))
        return error.exit_code
    if not found:
        progress.say("no offset written, see docs/first_run.md")
        return FOUND_WRONG
    path = folder.path / "checked.yaml"
    write_values({**given, **found}, path)
    folder.become_latest()
    progress.say(f"drive with --params {path}" if passed else f"{path} holds the body's offset, not the LIDAR's pose")
    return 0 if passed else FOUND_WRONG


def _prepared(options: Options) -> Preparation:
    preparation = prepare(options)
    world, room = preparation.world, MOST_DISTANCE + preparation.settings.robot.radius
    if preparation.robot.simulated and world.start is not None and not has_room(world, world.start, room):
        raise StartError(
            f"--check: world {world.name} has less than {MOST_DISTANCE:g} m free around the robot at its start; "
            f"use --world {FLOOR}"
        )
    programs = {name: path for name, path in preparation.programs.items() if name not in NOT_NEEDED}
    return replace(preparation, programs=programs)


class Check:
    """One check of a robot and mocap_node that run already."""

    def __init__(self, graph: Graph, yes: bool, lidar: LidarScans | None = None) -> None:
        """`yes` moves the robot without asking; `lidar` is given where the LIDAR's mounting pose is to be found."""
        self._graph = graph
        self._lidar = lidar
        self._settings = graph.preparation.settings
        self._lag = self._settings.robot.velocity_lag
        self._say = graph.progress.say
        self._yes = yes

    def run(self) -> tuple[dict[str, object], bool]:
        """Returns the parameters found by key, none without the body's offset; and whether the check passed."""
        self._say(f"checking {', '.join(self._graph.preparation.programs)}")
        wait_until_poses_come(self._graph)
        self._loop = OpenLoop(self._graph)
        found: dict[str, object] = {}
        try:
            self._judge([*self._nodes(), *self._stream(), *self._scans()])
            self._graph.is_ready = True  # from now on no other node may command
            offset = self._offset()
            found = {f"mocap.body_offset_{key}": round(getattr(offset, key), 5) for key in ("x", "y", "yaw")}
            if self._lidar is not None:
                finding, mount = self._lidar.find(self._loop.poses, offset)
                found |= mount
                self._judge([finding])
        except FoundWrong:
            return found, False
        return found, True

    def _nodes(self) -> list[Finding]:
        recorder, begun = self._graph.recorder, time.monotonic()
        names = [self._graph.preparation.full_name(name) for name in self._graph.preparation.programs]

        def silent() -> list[str]:
            return [name for name in names if recorder.reported_at.get(name, 0.0) < begun]

        # in simulated time that waits for the nodes, their reports are soon too far apart
        patience = REPORT_PATIENCE if self._graph.stepped is None else math.inf
        self._graph.wait(lambda: not silent(), patience, lambda: f"no diagnostics of {', '.join(silent())}")
        return findings.node_findings([recorder.reported[name] for name in names])

    def _stream(self) -> list[Finding]:
        poses = self._loop.rest(WATCHING_TIME)
        received = np.array(self._loop.received[-len(poses) :])
        stamps, positions = np.array([p.stamp for p in poses]), np.array([p.position for p in poses])
        return findings.stream_findings(stream_quality(stamps, received, positions), self._settings)

    def _scans(self) -> list[Finding]:
        return [] if self._lidar is None else [self._lidar.coming(self._loop.poses, self._loop.received)]

    def _offset(self) -> BodyOffset:
        """The body's offset, from motions of the robot.

        Raises:
            FoundWrong: something is wrong, or the offset stays uncertain.
        """
        slow = body_motions.careful(self._settings.robot)
        across = f"{200 * slow.reach:g} cm at {slow.speed:g} m/s"
        self.ask(
            f"drive {across}, forward, back, left and right, and turn in place at {slow.yaw_rate:g} rad/s, a minute"
        )
        refuse_kept_stop(self._graph)
        try:
            with self._loop.resumed():
                motions = body_motions.drive_each_way(self._loop, slow, self._lag)
                axes = findings.axes_finding(estimate(motions, self._lag).axes)
                if axes.verdict == WRONG:
                    self._judge([axes])
                while len(motions.turns) < body_motions.CAREFUL_ROUNDS:
                    motions = body_motions.one_more_round(self._loop, motions, slow, self._lag)
            known = estimate(motions, self._lag)
            if not known.is_certain and not _is_wrong(_found(known)):
                motions = self._go_on(motions)
        except InterruptedTooOften:
            self._judge([self._interruptions])
        except body_motions.Strayed as error:
            why = "wheels that slip or are set wrongly, a tilted floor, or wrong poses"
            self._judge([self._interruptions, Finding(WRONG, f"{error}: {why}")])
        known = estimate(motions, self._lag)
        self._judge([self._interruptions, *_found(known)])
        if not known.is_certain:  # a heading off by degrees turns every command
            self._say("  a floor with a better grip, or motion capture with less noise, gives more")
            raise FoundWrong
        return known.offset

    def _go_on(self, motions: Motions) -> Motions:
        """The quicker motions.

        Raises:
            Strayed: the robot is too far from where it began.
        """
        pace, lag = body_motions.quick(self._settings.robot), self._lag
        offset = estimate(motions, lag).offset
        position, yaw = 1e3 * offset.position_uncertainty, degrees(offset.yaw_uncertainty)
        self._say(f"  so far +- {position:.1f} mm and {yaw:.2f} deg")
        self.ask(
            f"go on for a minute and a half, up to {100 * pace.reach:g} cm to each side at up to {pace.limit:g} m/s, "
            f"turning at {pace.yaw_rate:g} rad/s"
        )
        with self._loop.resumed():
            for _ in range(body_motions.QUICK_ROUNDS):
                motions = body_motions.one_more_round(self._loop, motions, pace, lag)
        return motions

    @property
    def _interruptions(self) -> Finding:
        return findings.interruption_finding(self._loop.interruptions)

    def _judge(self, found: Sequence[Finding]) -> None:
        """Prints findings.

        Raises:
            FoundWrong: one of them is wrong.
        """
        for finding in found:
            self._say(f"  {finding.verdict:<8}  {finding.text}")
        if _is_wrong(found):
            raise FoundWrong

    def ask(self, motion: str) -> None:
        """Asks the user for consent to a motion, and waits for the answer.

        Raises:
            Declined: the answer is not yes.
        """
        if self._yes:
            self._say(f"the robot is going to {motion}")
            return
        room = f"{100 * MOST_DISTANCE:g} cm"
        self._say(f"The robot is going to {motion}. Clear {room} around it. y and Enter to go, Enter to end:")
        # waits without blocking, so that Ctrl-C is noticed and messages are taken
        while not select.select([sys.stdin], [], [], 0.0)[0]:
            self._graph.step()
        if sys.stdin.readline().strip().lower() not in ("y", "yes"):
            raise Declined("not moved; the rest was not checked")


def _found(known: MotionEstimate) -> list[Finding]:
    turns = [findings.turn_finding(known.turns)] if known.turns else []
    return [
        *turns,
        findings.axes_finding(known.axes),
        findings.drift_finding(known.axes, known.offset),
        findings.offset_finding(known),
    ]


def _is_wrong(found: Sequence[Finding]) -> bool:
    return any(finding.verdict == WRONG for finding in found)
