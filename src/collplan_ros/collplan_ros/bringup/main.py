"""Entry point of bringup: starts a robot and its nodes, gives the goal, monitors the run, and writes the run folder."""

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatus

from collplan_core.evaluation.run_end import ABORTED, CANCELED, REACHED, RunMonitor
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
from collplan_ros.bringup.graph import Graph
from collplan_ros.bringup.options import Options, parse
from collplan_ros.bringup.preparation import prepare, write_used_parameters
from collplan_ros.bringup.progress import Progress
from collplan_ros.bringup.results import write_results
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.runs.recorder import GoalReport
from collplan_ros.runs.run_log import RunLog

REST_PATIENCE = 2.0
"""Longest wait for the robot to stop after a run [s]."""
REST_SPEED = 0.03
"""Speed below which the robot counts as at rest [m/s]."""
PLANNER = "planner_node"
OUTCOMES = {
    GoalStatus.STATUS_SUCCEEDED: REACHED,
    GoalStatus.STATUS_ABORTED: ABORTED,
    GoalStatus.STATUS_CANCELED: CANCELED,
}
"""Outcome of a run by the final status of its goal."""


@dataclass(frozen=True)
class RunResult:
    """Result of a run.

    Attributes:
        outcome: reached, timeout, stuck, aborted, canceled, node_died, graph_lost or interrupted.
        exit_code: 0 only when the goal was reached.
        message: reason, where the run was broken off or the goal given up; else empty.
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

    def __enter__(self) -> "Bringup":
        try:
            self.graph.__enter__()
        except StartError:
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
        """Gives the goal (2,) [m], the prepared one by default, and monitors the run; returns the outcome."""
        target = self.preparation.goal if goal is None else goal
        settings, graph = self.preparation.settings, self.graph
        graph.recorder.begin()
        graph.give_goal(target)
        monitor = RunMonitor(settings.trial, graph.pose.stamp)
        while True:
            pose, goal_report = graph.pose, graph.recorder.goal
            position = np.array([pose.x, pose.y])
            if goal_report is not None and goal_report.status == GoalStatus.STATUS_EXECUTING:
                monitor.executing(pose.stamp)
            outcome = outcome_from_status(goal_report, pose.sent) or monitor.outcome(pose.stamp, position)
            if outcome:
                return outcome
            distance = float(np.linalg.norm(position - target))
            self.progress.show(self._elapsed, distance, self.log.maneuver_at(pose.sent), len(self.log.impacts))
            graph.step()

    @property
    def _elapsed(self) -> float:
        begin = self.log.time_zero
        return 0.0 if begin is None else max(0.0, self.graph.pose.stamp - begin)

    def come_to_rest(self) -> None:
        """Ends the recording, and waits until it is whole, the robot rests, and the goal's final status is reported."""
        graph = self.graph
        graph.recorder.finish()
        deadline = time.monotonic() + REST_PATIENCE

        def at_rest() -> bool:
            goal = graph.recorder.goal
            ended = goal is None or goal.status in OUTCOMES
            return ended and graph.recorder.is_complete and bool(np.hypot(graph.pose.vx, graph.pose.vy) <= REST_SPEED)

        while time.monotonic() < deadline and not at_rest():
            graph.step()


def outcome_from_status(goal: GoalReport | None, sent: float) -> str | None:
    """Outcome of a run by the goal's status, None while the goal is active.

    A status is used only once the poses sent before it were handled, `sent` [s] being when the newest was sent: the
    time of arrival is taken from those poses.
    """
    return OUTCOMES.get(goal.status) if goal is not None and goal.sent <= sent else None


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
            reason = bringup.graph.last_message(PLANNER) if outcome == ABORTED else ""
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
        f"{end} ({kind}{summary['path_length_m']:.2f} m, {summary['impacts']} impacts, "
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
