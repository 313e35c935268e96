"""The program bringup: one whole run, from its options to its results and exit code."""

import math
import signal
import sys
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from collplan_core.evaluation.run_end import ABORTED, REACHED
from collplan_core.parameters import Settings
from collplan_core.strategies import is_careful
from collplan_ros.bringup import ending
from collplan_ros.bringup.driving import Bringup, wait_until_ready
from collplan_ros.bringup.options import VIEWER, Options, parse
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.progress import Progress
from collplan_ros.node_kit.stop_signal import StopSignal
from collplan_ros.run.description import PARAMETERS
from collplan_ros.run.record import counted_impacts
from collplan_ros.run.recorded_run import RecordedRun, read_run
from collplan_ros.run.result_files import PICTURE, draw_trajectory, write_result_files
from collplan_ros.run.whole_file import RecordError, RunError, replacing


def write_results(run: RecordedRun, preparation: Preparation, outcome: str, reason: str = "") -> dict[str, Any]:
    """Writes trajectory, impacts and summary of a run, each whole, or raises RecordError; `reason` is why it ended."""
    said = {"reason": reason, "repeat": preparation.options.repeated(run.folder / PARAMETERS, preparation.goal)}
    return write_result_files(run, preparation.goal, outcome, said)


def make_pictures(run: RecordedRun, preparation: Preparation) -> list[str]:
    """Draws trajectory.png and writes run.html, of a run with poses; returns why one of them is missing."""

    def picture() -> None:
        with replacing(run.folder / PICTURE) as path:
            draw_trajectory(path, run, preparation.goal)

    def page() -> None:
        from collplan_ros.run.page import write_run_page

        write_run_page(run)

    missing = []
    # what they import is slow to load
    for name, make in ((PICTURE, picture), ("run.html", page)) if run.log.poses else ():
        try:
            make()
        except Exception as error:  # whatever it is: the run is over, and its figures are written
            missing.append(f"{name} not made: {type(error).__name__}: {error}")
    return missing


@dataclass(frozen=True)
class RunResult:
    """Result of a run."""

    outcome: str  # of its goal (reached, timeout, ...), or of what broke it off (node_died, record_lost, ...)
    exit_code: int  # 0 only when the goal was reached
    message: str  # why the run was broken off or the goal not reached; empty where it was reached or canceled
    folder: Path
    summary: dict[str, Any]  # content of summary.json; empty where it could not be written


def run(options: Options, progress: Progress | None = None) -> RunResult:
    """Performs one whole run: start, goal, end, results; StartError where the request cannot be fulfilled."""
    bringup = Bringup(options, progress)
    with closing(bringup.folder):
        return _finished(bringup, *_driven(bringup))


def _driven(bringup: Bringup) -> tuple[str, int, str]:
    """Starts the graph, drives to the requested goal, and stops; returns outcome, exit code and message."""
    options, say = bringup.preparation.options, bringup.progress.say
    try:
        with bringup:
            say(_announcement(bringup.preparation))
            wait_until_ready(bringup)
            if bringup.recorder.blind > 0.0:
                say(_blindness(bringup.recorder.blind, bringup.preparation.settings))
            if options.view:
                address = bringup.recorder.status(VIEWER).message.partition(",")[0]
                say(f"\n    watch it in a browser on this machine:   {address}\n")
            if why := bringup.recorder.emergency_stop:  # kept: it must not drive off when somebody clears that
                clear = bringup.complaints.name("clear_estop")
                raise ending.GraphError(
                    f"{why}: call {clear}, or press Clear emergency stop on the page, then start again"
                )
            if options.again:
                bringup.drive_laps()
            outcome = bringup.drive()
            bringup.come_to_rest()
            reason = bringup.reason(outcome)
            if outcome == REACHED and (held := bringup.recorder.robot_held):
                raise ending.DrivesOn(f"the goal was reached, and then the robot was held: {held}")
    except RecordError as error:
        return "record_lost", ending.RECORD_LOST, str(error)
    except (ending.GraphError, ending.Interrupted) as error:
        meant = options.again and error.exit_code == 128 + signal.SIGINT
        return error.outcome, 0 if meant else error.exit_code, str(error)
    if outcome in (*ending.MONITORED, ABORTED):
        say(reason)
    return outcome, 0 if outcome == REACHED else ending.NOT_REACHED, reason


def _finished(bringup: Bringup, outcome: str, exit_code: int, message: str) -> RunResult:
    """Writes the results of a run that has ended."""
    folder, preparation, say = bringup.folder, bringup.preparation, bringup.progress.say
    say("writing the results ...")
    try:
        with StopSignal().listening():  # another Ctrl-C does not cost what is written now
            recorded = read_run(folder.path)
            summary = write_results(recorded, preparation, outcome, message)
    except (RecordError, RunError, OSError) as error:
        say(f"{error}; what was recorded until then is in {folder.recording}")
        return RunResult(outcome, ending.RECORD_LOST, message or str(error), folder.path, {})
    result = RunResult(outcome, exit_code, message, folder.path, summary)
    try:
        for missing in make_pictures(recorded, preparation) if preparation.options.pictures else ():
            say(missing)
    except KeyboardInterrupt:
        say(_conclusion(result))
        raise
    return result


def _announcement(preparation: Preparation) -> str:
    settings, goal = preparation.settings, preparation.goal
    about = (
        f"world {settings.simulator.world}, strategy {settings.planner.strategy}, seed {settings.simulator.seed}, "
        f"goal ({goal[0]:g}, {goal[1]:g}); starting {', '.join(preparation.programs)}"
    )
    return "\n".join(filter(None, (preparation.speed, about, preparation.lidar)))


def _blindness(blind: float, settings: Settings) -> str:
    """Returns what a LIDAR that leaves out an angle [rad] means for the run."""
    slow = "slowly" if is_careful(settings.planner.strategy) else "at any speed"
    turns = "true" if settings.controller.turns_to_look else "false"
    found = f"the LIDAR sees nothing in {math.degrees(blind):.0f} of 360 degrees"
    return f"{found}: what no scan showed is entered {slow}; controller.turns_to_look is {turns}"


def _conclusion(result: RunResult) -> str:
    summary = result.summary
    if not summary:
        return f"run ended: {result.outcome}\n{result.folder}"
    arrival = summary["arrival_time_s"]
    end = f"goal reached in {arrival:.2f} s" if arrival is not None else f"goal not reached: {result.outcome}"
    if result.outcome == "interrupted" and not result.exit_code:
        end = "driven there and back until Ctrl-C"
    kind = "simulated, " if summary["simulated"] else ""
    drove = (
        f"{end} ({kind}{summary['path_length_m']:.2f} m, {counted_impacts(summary['impacts'])}, "
        f"{summary['impacts_foreseen']} of them foreseen, {summary['impacts_deliberate']} deliberate)"
    )
    drive = summary.get("drive", {}).get("in_words", "")
    lines = summary["machine"], drive, drove, str(result.folder), f"to repeat it: {summary['repeat']}"
    return "\n".join(filter(None, lines))


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    options = parse(args)
    try:
        result = run(options)
    except ending.StartError as error:
        print(f"bringup: {error}", file=sys.stderr)
        return ending.NOT_STARTED
    except KeyboardInterrupt:  # a second Ctrl-C, while the pictures are drawn
        return 130
    Progress().say(_conclusion(result))
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
