"""Entry point of bringup: starts a robot and its nodes, gives the goal, monitors the run, and writes the run folder."""

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.evaluation.run_end import ABORTED, REACHED, STUCK, TIMEOUT, RunMonitor
from collplan_ros.bringup.check import check
from collplan_ros.bringup.failures import (
    GRAPH_LOST,
    NOT_REACHED,
    NOT_STARTED,
    GraphError,
    Interrupted,
    NodeDied,
    StartError,
)
from collplan_ros.bringup.graph import LATE, Graph
from collplan_ros.bringup.options import Options, parse
from collplan_ros.bringup.outcome import OUTCOMES, outcome_of
from collplan_ros.bringup.preparation import prepare, write_used_parameters
from collplan_ros.bringup.progress import Progress
from collplan_ros.bringup.results import counted_impacts, write_results
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.runs.run_log import RunLog

WHOLE_PATIENCE = 10.0
"""Longest wait for what is still under way of a run's record [s]."""
REST_PATIENCE = 2.0
"""Longest wait for the robot to stop after a run [s]."""
REST_SPEED = 0.03
"""Speed below which the robot counts as at rest [m/s]."""
PLANNER = "planner_node"


@dataclass(frozen=True)
class RunResult:
    """Result of a run.

    Attributes:
        outcome: reached, timeout, stuck, aborted, canceled, node_died, graph_lost or interrupted.
        exit_code: 0 only when the goal was reached.
        message: why the run was broken off or the goal not reached; empty where it was reached or canceled.
        folder: the run folder.
        summary: content of summary.json.
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
        NodeDied, GraphError, Interrupted: from every method that waits.
    """

    def __init__(self, options: Options, progress: Progress | None = None) -> None:
        """Checks everything and makes the run folder."""
        self.progress = progress or Progress()
        self.preparation = prepare(options)
        self.folder = RunFolder(options.out)
        write_used_parameters(self.folder.parameters, self.preparation.settings)
        self.graph = Graph(self.preparation, self.folder, self.progress)
        self._monitor: RunMonitor | None = None

    def __enter__(self) -> "Bringup":
        try:
            self.graph.__enter__()
            self.folder.become_latest()
        except StartError:
            self.graph.__exit__()
            self.folder.discard()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        self.graph.__exit__(*exception)

    @property
    def log(self) -> RunLog:
        """Log of everything received so far."""
        return self.graph.recorder.log

    def drive(self, goal: np.ndarray | None = None) -> str:
        """Gives the goal (2,) [m], the prepared one by default, and monitors the run.

        Returns:
            The outcome: reached, aborted or canceled as the planner says, else timeout or stuck.
        """
        target = self.preparation.goal if goal is None else goal
        graph = self.graph
        graph.recorder.begin()
        graph.give_goal(target)
        self._monitor = monitor = RunMonitor(self.preparation.settings.trial, graph.pose.stamp)
        while (outcome := outcome_of(graph.recorder.goal, graph.pose, monitor)) is None or self._is_outdated(outcome):
            self._show_progress(target)
            graph.step()
        return outcome

    def _is_outdated(self, outcome: str) -> bool:
        """Whether poses came too late to say TIMEOUT or STUCK; newer ones have then been taken."""
        if outcome not in (TIMEOUT, STUCK) or self.graph.recorder.lateness <= LATE:
            return False
        self.graph.catch_up()
        return True

    def _show_progress(self, target: np.ndarray) -> None:
        pose, begin = self.graph.pose, self.log.time_zero
        # a pose of a while ago is not where the robot is now
        if begin is not None and pose.stamp >= begin and time.time() - pose.sent <= LATE:
            distance = float(np.hypot(pose.x - target[0], pose.y - target[1]))
            maneuver = self.log.maneuver_at(pose.sent)
            self.progress.show(pose.stamp - begin, distance, maneuver, self.log.n_impacts)

    def come_to_rest(self) -> None:
        """Ends the recording, and waits until it is whole, the robot rests, and the goal's final status is reported."""
        recorder = self.graph.recorder
        recorder.finish()

        def at_rest() -> bool:
            pose, goal = self.graph.pose, recorder.goal
            return (goal is None or goal.status in OUTCOMES) and float(np.hypot(pose.vx, pose.vy)) <= REST_SPEED

        self._step_until(lambda: recorder.is_complete, WHOLE_PATIENCE)
        self._step_until(at_rest, REST_PATIENCE)

    def _step_until(self, condition: Callable[[], bool], patience: float) -> None:
        """Steps until the condition holds, at most `patience` [s]."""
        deadline = time.monotonic() + patience
        while time.monotonic() < deadline and not condition():
            self.graph.step()

    def reason(self, outcome: str) -> str:
        """Why the goal was not reached, in words, for the outcome of `drive`; the planner's word may come after it."""
        said = self.graph.last_message(PLANNER)
        if outcome == ABORTED:
            return said
        monitored = self._monitor.reason if self._monitor else ""
        return f"{outcome}: {monitored}; {PLANNER}: {said}" if outcome in (TIMEOUT, STUCK) else ""


def run(options: Options, progress: Progress | None = None) -> RunResult:
    """Performs one whole run: start, goal, end, results.

    Raises:
        StartError: what is asked for cannot be done; nothing was started.
    """
    bringup = Bringup(options, progress)
    outcome, exit_code, message = _driven(bringup)
    if message:
        bringup.progress.say(message)
    summary = write_results(bringup.folder, bringup.log, bringup.preparation, outcome, options)
    return RunResult(outcome, exit_code, message, bringup.folder.path, summary)


def _driven(bringup: Bringup) -> tuple[str, int, str]:
    """Drives a prepared run; returns outcome, exit code and message."""
    try:
        with bringup:
            bringup.progress.say(_announcement(bringup))
            bringup.graph.wait_until_ready()
            outcome = bringup.drive()
            bringup.come_to_rest()
            reason = bringup.reason(outcome)
    except NodeDied as error:
        return "node_died", GRAPH_LOST, str(error)
    except GraphError as error:
        return "graph_lost", GRAPH_LOST, str(error)
    except Interrupted as error:
        return "interrupted", 128 + error.number, str(error)
    return outcome, 0 if outcome == REACHED else NOT_REACHED, reason


def _announcement(bringup: Bringup) -> str:
    settings, goal = bringup.preparation.settings, bringup.preparation.goal
    return (
        f"world {settings.simulator.world}, strategy {settings.planner.strategy}, seed {settings.simulator.seed}, "
        f"goal ({goal[0]:g}, {goal[1]:g}); starting {', '.join(bringup.graph.pids)}"
    )


def _conclusion(result: RunResult) -> str:
    summary = result.summary
    arrival = summary["arrival_time_s"]
    end = f"goal reached in {arrival:.2f} s" if arrival is not None else f"goal not reached: {result.outcome}"
    kind = "simulated, " if summary["simulated"] else ""
    return (
        f"{end} ({kind}{summary['path_length_m']:.2f} m, {counted_impacts(summary['impacts'])}, "
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
