"""`bringup --check`: link, motion capture and axes of a robot before it drives by itself; finds the body's offset.

With --scan real and a world file it finds where the LIDAR is, too. Only the robot and mocap_node run. The check drives
slowly, in open loop, and asks before it does.
"""

import select
import sys
from collections.abc import Sequence
from dataclasses import replace
from math import degrees

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from collplan_core.calibration.body_motions import (
    CAREFUL_ROUNDS,
    MOST_DISTANCE,
    Estimate,
    Motions,
    Strayed,
    careful,
    drive_each_way,
    estimate,
    one_more_round,
    quick,
    time_missing,
)
from collplan_core.calibration.mocap_offset import BodyOffset
from collplan_core.calibration.stream_quality import stream_quality
from collplan_core.parameters.file import read_parameters, write_values
from collplan_core.parameters.spec import ParameterError
from collplan_core.worlds import has_room
from collplan_ros.bringup.check_findings import (
    WRONG,
    Finding,
    axes_finding,
    drift_finding,
    interruption_finding,
    node_findings,
    offset_finding,
    stream_findings,
    turn_finding,
)
from collplan_ros.bringup.failures import FOUND_WRONG, GRAPH_LOST, GraphError, Interrupted, StartError
from collplan_ros.bringup.graph import Graph
from collplan_ros.bringup.lidar_scans import LidarScans
from collplan_ros.bringup.open_loop import InterruptedTooOften, OpenLoop
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import Preparation, prepare, write_used_parameters
from collplan_ros.bringup.progress import Progress
from collplan_ros.bringup.robots import REAL
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.messages.qos import EVERY_ONE

NOT_NEEDED = ("lidar_node", "planner_node", "controller_node")
REPORT_PATIENCE = 10.0
"""Longest wait for a report of every node [s]; each sends one a second, of a simulation that may wait for others."""
WATCHING_TIME = 2.0
"""Time for which poses of the robot at rest are recorded [s]."""
MOST_TIME = 360.0
"""Longest time for which it goes on where the first motions do not determine the offset [s]."""
TELLING_PERIOD = 30.0
"""Time after which it says how certain the offset is by then [s]."""
FLOOR = "floor"
"""The world of a simulated robot, unless another is said."""


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
        with Graph(preparation, folder, progress, recording=False, commands=True) as graph:
            if options.scan == REAL and not options.world:
                progress.say("without --world the place of the LIDAR is not looked for")
            lidar = LidarScans(graph, preparation) if options.scan == REAL and options.world else None
            found, passed = Check(graph, preparation, progress, options.yes, lidar).run()
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
    if not found:
        progress.say("no offset written, see docs/first_run.md")
        return FOUND_WRONG
    path = folder.path / "checked.yaml"
    write_values({**_given(options), **found}, path)
    folder.become_latest()
    if not passed:
        progress.say(f"the body's offset is in {path}, the place of the LIDAR is not")
        return FOUND_WRONG
    progress.say(f"drive with --params {path}")
    return 0


def _prepared(options: Options) -> Preparation:
    preparation = prepare(replace(options, world=_world(options)))
    settings, world = preparation.settings, preparation.world
    room = MOST_DISTANCE + settings.robot.radius
    if preparation.robot.simulated and world.start is not None and not has_room(world, world.start, room):
        raise StartError(
            f"--check: world {world.name} has less than {MOST_DISTANCE:g} m free around the robot at its start; "
            f"take --world {FLOOR}"
        )
    programs = {name: path for name, path in preparation.programs.items() if name not in NOT_NEEDED}
    return replace(preparation, programs=programs)


def _world(options: Options) -> str | None:
    """The world's name, where the command line or the parameter file does not say another."""
    if options.world is not None or (options.params and "simulator.world" in _given(options)):
        return options.world
    return FLOOR


def _given(options: Options) -> dict[str, object]:
    """Values of the given parameter file.

    Raises:
        StartError: it cannot be read.
    """
    try:
        return read_parameters(options.params) if options.params else {}
    except ParameterError as error:
        raise StartError(str(error)) from None


def _offset_values(offset: BodyOffset) -> dict[str, object]:
    return {f"mocap.body_offset_{key}": round(getattr(offset, key), 5) for key in ("x", "y", "yaw")}


class Check:
    """One check of a robot and mocap_node that run already."""

    def __init__(
        self, graph: Graph, preparation: Preparation, progress: Progress, yes: bool, lidar: LidarScans | None = None
    ) -> None:
        self._graph = graph
        self._lidar = lidar
        self._settings = preparation.settings
        self._names = [graph.full_name(name) for name in preparation.programs]
        self._progress = progress
        self._yes = yes
        self._statuses: dict[str, DiagnosticStatus] = {}

    def run(self) -> tuple[dict[str, object], bool]:
        """The parameters found, by key, none where the body's offset is not; and whether nothing is wrong."""
        self._progress.say(f"checking {', '.join(self._graph.pids)}")
        self._graph.wait_until_poses_come()
        self._loop = OpenLoop(self._graph, self._settings)
        if not self._passes([*self._nodes(), *self._stream(), *self._scans()]):
            return {}, False
        self._loop.refuse_other_publishers()
        offset = self._motions()
        if offset is None:
            return {}, False
        found = _offset_values(offset)
        if self._lidar is None:
            return found, True
        finding, mount = self._lidar.find(self._loop.poses, offset)
        return {**found, **mount}, self._passes([finding])

    def _nodes(self) -> list[Finding]:
        self._graph.node.create_subscription(DiagnosticArray, "/diagnostics", self._take_statuses, EVERY_ONE)

        def silent() -> list[str]:
            return [name for name in self._names if name not in self._statuses]

        self._graph.wait(lambda: not silent(), REPORT_PATIENCE, lambda: f"no diagnostics of {', '.join(silent())}")
        return node_findings(self._statuses)

    def _take_statuses(self, message: DiagnosticArray) -> None:
        self._statuses.update({s.name: s for s in message.status if s.name in self._names})

    def _stream(self) -> list[Finding]:
        poses = self._loop.rest(WATCHING_TIME)
        received = np.array(self._loop.received[-len(poses) :])
        stamps, positions = np.array([p.stamp for p in poses]), np.array([p.position for p in poses])
        return stream_findings(stream_quality(stamps, received, positions), self._settings)

    def _scans(self) -> list[Finding]:
        return [] if self._lidar is None else [self._lidar.coming(self._loop.poses, self._loop.received)]

    def _motions(self) -> BodyOffset | None:
        slow, lag = careful(self._settings.robot), self._settings.robot.velocity_lag
        across = f"{200 * slow.reach:g} cm at {slow.speed:g} m/s"
        self.ask(
            f"drive {across}, forward, back, left and right, and turn in place at {slow.yaw_rate:g} rad/s, a minute"
        )
        self._graph.refuse_kept_stop()
        try:
            with self._loop.resumed():
                motions = drive_each_way(self._loop, slow, lag)
                axes = axes_finding(estimate(motions, lag).axes)
                if axes.verdict == WRONG:
                    self._passes([axes])
                    return None
                while len(motions.turns) < CAREFUL_ROUNDS:
                    motions = one_more_round(self._loop, motions, slow, lag)
            known = estimate(motions, lag)
            if not known.is_certain and not _is_wrong(self._found(known)):
                motions = self._go_on(motions)
        except InterruptedTooOften:
            self._passes([interruption_finding(self._loop.interruptions)])
            return None
        except GraphError:
            # what was lost may have been lost for the same reason
            if self._loop.interruptions.are_many:
                self._passes([interruption_finding(self._loop.interruptions)])
            raise
        except Strayed as error:
            why = "wheels that slip or are set wrongly, a tilted floor, or wrong poses"
            self._passes([interruption_finding(self._loop.interruptions), Finding(WRONG, f"{error}: {why}")])
            return None
        return self._judged(motions, lag)

    def _judged(self, motions: Motions, lag: float) -> BodyOffset | None:
        known, interruptions = estimate(motions, lag), self._loop.interruptions
        if not self._passes([interruption_finding(interruptions), *self._found(known)]):
            return None
        if not known.is_certain:  # a heading off by degrees turns every command
            missing = time_missing(motions, quick(self._settings.robot), lag)
            less = "a machine that is less busy" if interruptions.are_many else "a floor with a better grip"
            self._progress.say(f"  that would take {missing:.0f} s more: {less} needs less")
            return None
        return known.offset

    def _found(self, known: Estimate) -> list[Finding]:
        turns = [turn_finding(known.turns)] if known.turns else []
        return [*turns, axes_finding(known.axes), drift_finding(known.axes, known.offset), offset_finding(known)]

    def _go_on(self, motions: Motions) -> Motions:
        """Quicker motions until the offset is certain, for MOST_TIME at most.

        Raises:
            Strayed: the robot is too far from where it began.
        """
        pace, lag = quick(self._settings.robot), self._settings.robot.velocity_lag
        missing = min(time_missing(motions, pace, lag), MOST_TIME)
        self._progress.say(f"  so far {_certainty(estimate(motions, lag))}")
        self.ask(
            f"go on for about {missing:.0f} s, up to {100 * pace.reach:g} cm to each side at up to {pace.limit:g} m/s, "
            f"turning at {pace.yaw_rate:g} rad/s"
        )
        begun = told = self._graph.pose.stamp
        with self._loop.resumed():
            while not (known := estimate(motions, lag)).is_certain and self._graph.pose.stamp - begun < MOST_TIME:
                if self._graph.pose.stamp - told >= TELLING_PERIOD:
                    told = self._graph.pose.stamp
                    missing = time_missing(motions, pace, lag)
                    self._progress.say(f"  {_certainty(known)}, about {missing:.0f} s more{self._share_interrupted}")
                motions = one_more_round(self._loop, motions, pace, lag)
        return motions

    @property
    def _share_interrupted(self) -> str:
        found = self._loop.interruptions
        return f"; {found.interrupted} of {found.motions} motions were interrupted" if found.interrupted else ""

    def _passes(self, findings: Sequence[Finding]) -> bool:
        """Prints the findings; whether none of them is wrong."""
        for finding in findings:
            self._progress.say(f"  {finding.verdict:<8}  {finding.text}")
        return not _is_wrong(findings)

    def ask(self, motion: str) -> None:
        """Asks the user for consent to a motion, and waits for the answer.

        Raises:
            Declined: the answer is not yes.
        """
        if self._yes:
            self._progress.say(f"the robot is going to {motion}")
            return
        room = f"{100 * MOST_DISTANCE:g} cm"
        self._progress.say(f"The robot is going to {motion}. Clear {room} around it. y and Enter to go, Enter to end:")
        # waits without blocking, so that Ctrl-C is noticed and messages are taken
        while not select.select([sys.stdin], [], [], 0.0)[0]:
            self._graph.step()
        if sys.stdin.readline().strip().lower() not in ("y", "yes"):
            raise Declined


def _is_wrong(findings: Sequence[Finding]) -> bool:
    return any(finding.verdict == WRONG for finding in findings)


def _certainty(known: Estimate) -> str:
    offset = known.offset
    return f"+- {1e3 * offset.position_uncertainty:.1f} mm and {degrees(offset.yaw_uncertainty):.2f} deg"
