"""The program replay: gives a recorded run to planner and controller again, and compares."""

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from collplan_core.command_line import parser_of
from collplan_core.parameters.spec import ParameterError
from collplan_core.replay.comparison import Comparison, Difference, Interruption, compare
from collplan_core.replay.journal import CONTROLLER, PLANNER, changes
from collplan_core.replay.values import JournalError
from collplan_ros.bringup.progress import Progress
from collplan_ros.replay.recorded_journals import RecordedJournals, read_journals
from collplan_ros.run.page import write_run_page
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.result_files import complete
from collplan_ros.run.whole_file import RecordError, RunError
from collplan_ros.run.writer import RECORDING

SAME, DIFFERENT, REFUSED, INTERRUPTED = 0, 1, 2, 3
"""Exit codes: bit-equal, a difference, a request that cannot be fulfilled, and equal up to a gap."""


def said_of(of: str, comparison: Comparison) -> Iterator[str]:
    """Yields the report's lines on a loop."""
    plans = f"{comparison.plans} plan{'' if comparison.plans == 1 else 's'}"
    commands = f"{comparison.commands} command{'' if comparison.commands == 1 else 's'}"
    done = f"{of}: {plans if of == PLANNER else commands} bit-equal, from {comparison.calls} inputs"
    yield done if comparison.end is None else f"{done}; then {comparison.end}"
    if isinstance(comparison.end, Difference) and comparison.beginning is not None:
        for change in changes(comparison.beginning.made_with):
            yield f"  {change}"


def exit_code(comparisons: Iterable[Comparison]) -> int:
    """Returns the exit code of the result; a difference has priority over a gap."""
    ends = [comparison.end for comparison in comparisons]
    if any(isinstance(end, Difference) for end in ends):
        return DIFFERENT
    return INTERRUPTED if any(isinstance(end, Interruption) for end in ends) else SAME


DESCRIPTION = """\
Gives the recorded inputs of a run to planner and controller again, without ROS and without a robot, and compares plan
by plan and command by command. The same code on the same machine decides the same to the last bit; otherwise the first
difference is shown, with the stamp of the newest pose then.

All bit-equal: exit code 0. A difference: 1. A request that cannot be fulfilled: 2. Equal up to a gap, or to where the
recording is cut off: 3.
"""
EPILOG = """\
examples:
  replay runs/latest                      the run again
  replay --page runs/latest               run.html of a run, which plays it in a browser
  replay trial.jsonl                      a trial's journal
"""


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    options = _parser().parse_args(args)
    # output that nobody reads any more, as after `head`, is dropped
    say = Progress().say
    folder = options.run.parent if options.run.name == RECORDING else options.run
    try:
        if made := complete(folder):
            say(made)
        if options.page:
            run = read_run(folder)
            print(f"written to {write_run_page(run)}")
            if run.note:
                say(run.note)
            return SAME
        journals = read_journals(options.run)
        found = _say_comparison(journals, say)
        if not journals.cut:
            return found
        say(journals.cut)
        return found or INTERRUPTED
    except (JournalError, ParameterError, RecordError, RunError) as error:
        print(f"replay: {error}", file=sys.stderr)
        return REFUSED


def _parser() -> argparse.ArgumentParser:
    parser = parser_of("replay", DESCRIPTION, EPILOG)
    add = parser.add_argument
    add("run", type=Path, metavar="RUN", help="run folder of bringup, its recording, or the journal of a trial")
    add("--page", action="store_true", help="write run.html, which plays the run in a browser, and no more")
    return parser


def _say_comparison(journals: RecordedJournals, say: Callable[[str], None]) -> int:
    found: list[Comparison] = []
    for of in (PLANNER, CONTROLLER):
        comparisons = list(compare(of, journals.events(of)))
        if not comparisons:
            say(f"{of}: no journal")
        for comparison in comparisons:
            say("\n".join(said_of(of, comparison)))
        found += comparisons
    return exit_code(found)


if __name__ == "__main__":
    sys.exit(main())
