"""`bringup --check`: link, motion capture and axes of a robot before it drives by itself; finds the body's offset.

With --scan real and a world file it finds where the LIDAR is, too. Only the robot and mocap_node run. The check drives
slowly, in open loop, and asks before it does.
"""

import select
import sys
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from collplan_core.calibration.body_motions import DISTANCE, MOST_ROUNDS, SPEED, drive_each_way, turn_in_place
from collplan_core.calibration.mocap_offset import BodyOffset, body_offset
from collplan_core.calibration.stream_quality import stream_quality
from collplan_core.parameters.file import read_parameters, write_values
from collplan_ros.bringup.check_findings import (
    DOUBTFUL,
    GOOD,
    WRONG,
    Finding,
    axes_finding,
    node_findings,
    offset_finding,
    stream_findings,
    turn_finding,
)
from collplan_ros.bringup.failures import FOUND_WRONG, GRAPH_LOST, GraphError, Interrupted, StartError
from collplan_ros.bringup.graph import Graph
from collplan_ros.bringup.lidar_scans import LidarScans
from collplan_ros.bringup.open_loop import OpenLoop
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import Preparation, prepare, write_used_parameters
from collplan_ros.bringup.progress import Progress
from collplan_ros.bringup.robots import REAL
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.messages.qos import EVERY_ONE

NOT_NEEDED = ("lidar_node", "planner_node", "controller_node")
REPORT_PATIENCE = 3.0
"""Longest wait for a report of every node, which each sends once a second [s]."""
WATCHING_TIME = 2.0
"""Time for which poses of the robot at rest are recorded [s]."""


class Declined(RuntimeError):
    """The user did not agree to a motion of the robot."""


def check(options: Options, progress: Progress) -> int:
    """Runs the whole check; returns an exit code, 0 where nothing is wrong.

    Raises:
        StartError: what is asked for cannot be done; nothing was started.
    """
    if not options.yes and not (sys.stdin and sys.stdin.isatty()):
        raise StartError("--check: asks before it moves the robot, so it needs a terminal, or --yes")
    preparation = _prepared(options)
    folder = RunFolder(options.out)
    write_used_parameters(folder.parameters, preparation.settings)
    try:
        with Graph(preparation, folder, progress) as graph:
            if options.scan == REAL and not options.world:
                progress.say("without --world the place of the LIDAR is not looked for")
            lidar = LidarScans(graph, preparation) if options.scan == REAL and options.world else None
            found = _Check(graph, preparation, progress, options.yes, lidar).run()
    except StartError:
        folder.discard()
        raise
    except Declined:
        progress.say("not moved; the rest was not checked")
        return FOUND_WRONG
    except Interrupted as error:
        progress.say(str(error))
        return 128 + error.number
    except GraphError as error:
        progress.say(str(error))
        return GRAPH_LOST
    if found is None:
        progress.say("no offset written, see docs/first_run.md")
        return FOUND_WRONG
    path = folder.path / "checked.yaml"
    write_values({**(read_parameters(options.params) if options.params else {}), **found}, path)
    folder.become_latest()
    progress.say(f"drive with --params {path}")
    return 0


def _prepared(options: Options) -> Preparation:
    preparation = prepare(options)
    programs = {name: path for name, path in preparation.programs.items() if name not in NOT_NEEDED}
    return replace(preparation, programs=programs)


def _offset_values(offset: BodyOffset) -> dict[str, object]:
    return {f"mocap.body_offset_{key}": round(getattr(offset, key), 5) for key in ("x", "y", "yaw")}


class _Check:
    """One check of a robot and mocap_node that run already."""

    def __init__(
        self, graph: Graph, preparation: Preparation, progress: Progress, yes: bool, lidar: LidarScans | None = None
    ) -> None:
        self._graph = graph
        self._lidar = lidar
        self._settings = preparation.settings
        self._names = list(preparation.programs)
        self._progress = progress
        self._yes = yes
        self._statuses: dict[str, DiagnosticStatus] = {}

    def run(self) -> dict[str, object] | None:
        """The parameters found, by key; None where something is wrong or the body's offset is too uncertain."""
        self._progress.say(f"checking {', '.join(self._graph.pids)}")
        self._graph.wait_until_poses_come()
        self._loop = OpenLoop(self._graph, self._settings)
        if not self._passes([*self._nodes(), *self._stream()]):
            return None
        self._loop.refuse_other_publishers()
        offset = self._motions()
        if offset is None or self._lidar is None:
            return None if offset is None else _offset_values(offset)
        finding, mount = self._lidar.find(self._loop.poses, offset)
        return {**_offset_values(offset), **mount} if self._passes([finding]) else None

    def _nodes(self) -> list[Finding]:
        self._graph.node.create_subscription(DiagnosticArray, "/diagnostics", self._take_statuses, EVERY_ONE)

        def silent() -> list[str]:
            reported = {name.rpartition("/")[2] for name in self._statuses}
            return [name for name in self._names if name not in reported]

        self._graph.wait(lambda: not silent(), REPORT_PATIENCE, lambda: f"no diagnostics of {', '.join(silent())}")
        return node_findings(self._statuses)

    def _take_statuses(self, message: DiagnosticArray) -> None:
        self._statuses.update({s.name: s for s in message.status if s.name.rpartition("/")[2] in self._names})

    def _stream(self) -> list[Finding]:
        poses = self._loop.rest(WATCHING_TIME)
        received = np.array(self._loop.received[-len(poses) :])
        stamps, positions = np.array([p.stamp for p in poses]), np.array([p.position for p in poses])
        return stream_findings(stream_quality(stamps, received, positions), self._settings)

    def _motions(self) -> BodyOffset | None:
        rate = min(self._settings.controller.max_yaw_rate, self._settings.robot.max_yaw_rate)
        self._ask(f"turn in place, once round at {rate:g} rad/s")
        self._loop.resume()
        lever, share = turn_in_place(self._loop, rate)
        if not self._passes([turn_finding(share)]):
            return None
        ways = f"drive {100 * DISTANCE:g} cm forward, back, left and back, at {SPEED:g} m/s"
        self._ask(f"{ways}, up to {MOST_ROUNDS} times")
        self._loop.resume()
        axes = drive_each_way(self._loop, lever, self._settings.robot.max_speed)
        offset = body_offset(axes, lever)
        found = offset_finding(offset, axes)
        passes = self._passes([axes_finding(axes), found])
        if found.verdict == DOUBTFUL:  # a heading off by degrees turns every command
            self._progress.say("  too uncertain to drive with: the floor, the wheels or the poses are too rough for it")
        return offset if passes and found.verdict == GOOD else None

    def _passes(self, findings: Sequence[Finding]) -> bool:
        """Prints the findings; whether none of them is wrong."""
        for finding in findings:
            self._progress.say(f"  {finding.verdict:<8}  {finding.text}")
        return all(finding.verdict != WRONG for finding in findings)

    def _ask(self, motion: str) -> None:
        """Asks the user for consent to a motion, and waits for the answer.

        Raises:
            Declined: the answer is not yes.
        """
        if self._yes:
            self._progress.say(f"the robot is going to {motion}")
            return
        self._progress.say(f"The robot is going to {motion}. Clear 40 cm around it. y and Enter to go, Enter to end:")
        # waits without blocking, so that Ctrl-C is noticed and messages are taken
        while not select.select([sys.stdin], [], [], 0.0)[0]:
            self._graph.step()
        if sys.stdin.readline().strip().lower() not in ("y", "yes"):
            raise Declined
