"""Entry point of bringup: starts a robot and its nodes, gives the goal, monitors the run, and writes the run folder."""

import signal
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatus

from collplan_core.evaluation.machine import pace_words
from collplan_core.evaluation.run_end import ABORTED, REACHED, STUCK, TIMEOUT, RunMonitor
from collplan_ros.bringup.check import check
from collplan_ros.bringup.failures import (
    GRAPH_LOST,
    NOT_REACHED,
    NOT_STARTED,
    RECORD_LOST,
    GraphError,
    Interrupted,
    NodeDied,
    StartError,
)
from collplan_ros.bringup.graph import COMMANDER, LATE, PLANNER, REST_PATIENCE, Graph
from collplan_ros.bringup.laps import EMERGENCY_STOP, drive_laps
from collplan_ros.bringup.options import Options, parse
from collplan_ros.bringup.outcome import OUTCOMES, outcome_of
from collplan_ros.bringup.preparation import prepare, write_used_parameters
from collplan_ros.bringup.progress import Progress
from collplan_ros.bringup.results import draw_picture, make_page, write_results
from collplan_ros.bringup.robots import VIEWER
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.bringup.signals import StopRequest
from collplan_ros.run.completion import complete_newest
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.run_error import RecordError, RunError
from collplan_ros.run.summary import counted_impacts

MONITORED = (TIMEOUT, STUCK)
"""Outcomes that no node tells."""
BROKEN_OFF = (GraphError, Interrupted, RecordError)
"""What ends a run before its outcome."""
CANCEL_PERIOD = 0.1
"""Period at which the planner is asked to end the goal, until it has [s]: it may not be discovered yet."""
CANCEL_PATIENCE = 0.3
"""Longest wait for the end of a goal that was canceled [s]."""
ACTIVE = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING)
"""Status of a goal that the robot is on the way to."""


@dataclass(frozen=True)
class RunResult:
    """Result of a run.

    Attributes:
        outcome: reached, timeout, stuck, aborted, canceled, emergency_stop, node_died, graph_lost, record_lost or
            interrupted.
        exit_code: 0 only when the goal was reached.
        message: why the run was broken off or the goal not reached; empty where it was reached or canceled.
        folder: the run folder.
        summary: content of summary.json; empty where it could not be written.
    """

    outcome: str
    exit_code: int
    message: str
    folder: Path
    summary: dict[str, Any]


class Bringup:
    """One run, a context manager: entering starts the graph, leaving stops it.

    Most scripts need only `run()`; this class is for those that act during the run. Use it in a thread that lives as
    long as the graph: the nodes are killed when the thread that started them ends.

    Raises:
        StartError: what is asked for cannot be done; nothing was started.
        NodeDied, GraphError, Interrupted, RecordError: from every method that waits.
    """

    def __init__(self, options: Options, progress: Progress | None = None) -> None:
        """Checks everything and makes the run folder."""
        self.progress = progress or Progress()
        self.preparation = prepare(options)
        self.folder = RunFolder(options.out)
        write_used_parameters(self.folder.parameters, self.preparation.settings)
        self.graph = Graph(self.preparation, self.folder, self.progress)
        self._why = ""

    def __enter__(self) -> "Bringup":
        try:
            self.graph.__enter__()
            self.folder.become_latest()
        except StartError:
            self.graph.__exit__()
            self.folder.discard()
            raise
        except BROKEN_OFF as error:
            self.progress.say(str(error))
            raise
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, BROKEN_OFF):  # at once: to stop the nodes takes some seconds
            self.progress.say(str(error))
        try:
            self.graph.__exit__(kind, error, trace)
        except RecordError as lost:  # the last lines do not fit on the disk
            self.progress.say(str(lost))
            raise

    def drive(self, goal: np.ndarray | None = None) -> str:
        """Gives the goal (2,) [m], the prepared one by default, and monitors the run.

        Returns:
            The outcome: reached, aborted or canceled as the planner says, else timeout, stuck or emergency_stop.
        """
        target = self.preparation.goal if goal is None else goal
        graph = self.graph
        graph.recorder.begin(self.preparation.robot.simulated)
        graph.give_goal(target)
        monitor = RunMonitor(self.preparation.settings.trial, graph.pose.stamp)
        while (outcome := outcome_of(graph.recorder.goal, graph.pose, monitor)) is None or self._is_outdated(outcome):
            if graph.recorder.emergency_stop:
                self.progress.say(self.reason(EMERGENCY_STOP))
                return EMERGENCY_STOP
            self._show_progress(target)
            graph.step()
            monitor.commanded(graph.recorder.maneuver)
        # now: what ends the goal makes the controller stand for that reason
        self._why = f"{outcome}: {self._why_not_there(monitor.reason)}"
        return outcome

    def _is_outdated(self, outcome: str) -> bool:
        """Whether poses came too late to say TIMEOUT or STUCK; newer ones have then been taken."""
        if outcome not in MONITORED or self.graph.recorder.lateness <= LATE:
            return False
        self.graph.catch_up()
        return True

    def _show_progress(self, target: np.ndarray) -> None:
        pose, recorder = self.graph.pose, self.graph.recorder
        begin = recorder.time_zero
        # a pose of a while ago is not where the robot is now
        if begin is not None and pose.stamp >= begin and recorder.age <= LATE:
            distance = float(np.hypot(pose.x - target[0], pose.y - target[1]))
            factor = recorder.lockstep.factor if recorder.lockstep else None
            self.progress.show(pose.stamp - begin, distance, recorder.maneuver, recorder.n_impacts, pace_words(factor))

    def come_to_rest(self) -> None:
        """Cancels a goal that has not ended, and waits until it has and the robot rests, at most REST_PATIENCE.

        A goal that has not ended within CANCEL_PATIENCE is not waited for: leave the graph then, which stops the robot.
        """
        graph, begun = self.graph, time.monotonic()
        due = begun
        while not (self._goal_has_ended and graph.at_rest) and (now := time.monotonic()) < begun + REST_PATIENCE:
            if not self._goal_has_ended:
                if now > begun + CANCEL_PATIENCE:
                    return
                if now >= due:
                    graph.cancel_goal()
                    due = now + CANCEL_PERIOD
            graph.step()

    def wait(self, condition: Callable[[], bool]) -> None:
        """Lets the graph run until a condition holds."""
        while not condition():
            self.graph.step()

    @property
    def goal_is_active(self) -> bool:
        """Whether the robot is on the way to a goal, whoever gave it."""
        goal = self.graph.recorder.goal
        return goal is not None and goal.status in ACTIVE

    @property
    def _goal_has_ended(self) -> bool:
        goal = self.graph.recorder.goal
        return goal is None or goal.status in OUTCOMES

    def reason(self, outcome: str) -> str:
        """Why the goal was not reached, in words, for the outcome of `drive`; the planner's word may come after it."""
        if outcome == ABORTED:
            return self.graph.last_message(PLANNER) + self.graph.frozen
        if outcome == EMERGENCY_STOP:
            return self.graph.recorder.emergency_stop
        return self._why if outcome in MONITORED else ""

    def _why_not_there(self, monitored: str) -> str:
        """Why the robot is not at the goal, in words: a hold says it all, a controller that stands more than a plan."""
        recorder, frozen = self.graph.recorder, self.graph.frozen
        if recorder.held:
            return f"the robot is held: {recorder.held}{frozen}"
        planner = f"{PLANNER}: {self.graph.last_message(PLANNER)}"
        return f"{monitored}{frozen}; {f'{COMMANDER}: {recorder.standing}' if recorder.standing else planner}"


def run(options: Options, progress: Progress | None = None) -> RunResult:
    """Performs one whole run: start, goal, end, results.

    Raises:
        StartError: what is asked for cannot be done; nothing was started.
    """
    bringup = Bringup(options, progress)
    with closing(bringup.folder):
        return _whole_run(bringup, options)


def _whole_run(bringup: Bringup, options: Options) -> RunResult:
    folder, preparation, say = bringup.folder, bringup.preparation, bringup.progress.say
    _complete_newest(options.out, say)
    outcome, exit_code, message = _driven(bringup, options)
    if outcome in (*MONITORED, ABORTED):
        say(message)
    say("writing the results ...")
    try:
        with StopRequest().listening():  # another Ctrl-C does not cost what is written now
            recorded = read_run(folder.path, options.pictures)
            results = write_results(recorded, preparation, outcome, options, message)
    except (RecordError, RunError, OSError) as error:
        say(f"{error}; what was recorded until then is in {folder.recording}")
        return RunResult(outcome, RECORD_LOST, message or str(error), folder.path, {})
    result = RunResult(outcome, exit_code, message, folder.path, results.summary)
    if options.pictures:
        try:
            for missing in filter(None, (draw_picture(recorded, results, preparation), make_page(recorded))):
                say(missing)
        except KeyboardInterrupt:
            say(_conclusion(result))
            raise
    return result


def _complete_newest(parent: Path, say: Callable[[str], None]) -> None:
    """Completes what the newest run that was killed and can be completed has left in the folder of run folders."""
    try:
        said = complete_newest(parent, say)
    except Exception as error:  # whatever is wrong with an old run must not keep this one from its goal
        said = f"an earlier run could not be completed: {error}"
    if said:
        say(said)


def _driven(bringup: Bringup, options: Options) -> tuple[str, int, str]:
    """Drives a prepared run; returns outcome, exit code and message."""
    try:
        with bringup:
            if bringup.preparation.speed:
                bringup.progress.say(bringup.preparation.speed)
            bringup.progress.say(_announcement(bringup))
            bringup.graph.wait_until_ready()
            if options.view:
                bringup.progress.say(_where_to_look(bringup))
            bringup.graph.refuse_kept_stop()
            if options.again:
                drive_laps(bringup, bringup.preparation.ends, bringup.progress.say)
            outcome = bringup.drive()
            bringup.come_to_rest()
            reason = bringup.reason(outcome)
    except NodeDied as error:
        return "node_died", GRAPH_LOST, str(error)
    except GraphError as error:
        return "graph_lost", GRAPH_LOST, str(error)
    except RecordError as error:
        return "record_lost", RECORD_LOST, str(error)
    except Interrupted as error:
        meant = options.again and error.number == signal.SIGINT
        return "interrupted", 0 if meant else 128 + error.number, str(error)
    return outcome, 0 if outcome == REACHED else NOT_REACHED, reason


def _where_to_look(bringup: Bringup) -> str:
    address = bringup.graph.last_message(VIEWER).partition(",")[0]
    return f"\n    watch it in a browser on this machine:   {address}\n"


def _announcement(bringup: Bringup) -> str:
    settings, goal = bringup.preparation.settings, bringup.preparation.goal
    return (
        f"world {settings.simulator.world}, strategy {settings.planner.strategy}, seed {settings.simulator.seed}, "
        f"goal ({goal[0]:g}, {goal[1]:g}); starting {', '.join(bringup.graph.pids)}"
    )


def _conclusion(result: RunResult) -> str:
    summary = result.summary
    if not summary:
        return f"run ended: {result.outcome}\n{result.folder}"
    arrival = summary["arrival_time_s"]
    end = f"goal reached in {arrival:.2f} s" if arrival is not None else f"goal not reached: {result.outcome}"
    if result.outcome == "interrupted" and not result.exit_code:
        end = "driven there and back until Ctrl-C"
    kind = "simulated, " if summary["simulated"] else ""
    machine = f"{summary['machine']}\n" if summary["machine"] else ""
    return (
        f"{machine}{end} ({kind}{summary['path_length_m']:.2f} m, {counted_impacts(summary['impacts'])}, "
        f"{summary['impacts_foreseen']} of them foreseen, {summary['impacts_deliberate']} deliberate)\n"
        f"{result.folder}\nonce more: {summary['repeat']}"
    )


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    options = parse(args)
    progress = Progress()
    try:
        if options.check:
            return check(options, progress)
        result = run(options, progress)
    except StartError as error:
        print(f"bringup: {error}", file=sys.stderr)
        return NOT_STARTED
    except KeyboardInterrupt:  # a second Ctrl-C, while the pictures are drawn
        return 130
    progress.say(_conclusion(result))
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
