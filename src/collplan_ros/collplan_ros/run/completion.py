"""Results of a run whose bringup was killed, made from its recording."""

from contextlib import closing
from pathlib import Path

import numpy as np

from collplan_core.evaluation.run_end import OUTCOMES
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.result_files import SUMMARY, write_result_files
from collplan_ros.run.whole_file import FolderLock, RecordError, RunError, has_end
from collplan_ros.run.writer import RECORDING

KILLED, WHY_KILLED = "killed", "bringup ended before the run did"
"""Outcome of a run whose bringup did not live to see another, and its reason."""
UNTOLD, WHY_UNTOLD = "ended", f"{RECORDING} does not hold why"
"""Outcome of a run that ended without a report of its goal's end, and its reason."""


def complete(folder: Path) -> str:
    """Makes the results that a killed bringup has not left in a run folder; returns a sentence about that, or ""."""
    if has_end(folder / SUMMARY) or not (folder / RECORDING).exists():
        return ""
    try:
        with closing(FolderLock(folder)):
            run = read_run(folder)
            if not np.isfinite(run.log.goal).all():
                return ""
            ends = [OUTCOMES[each.status] for each in run.log.statuses if each.status in OUTCOMES]
            outcome, why = (UNTOLD, WHY_UNTOLD) if run.has_ended or run.lacks else (KILLED, WHY_KILLED)
            if ends and outcome == UNTOLD:
                outcome, why = ends[-1], ""
            write_result_files(folder, run.log, run.world, run.log.goal, run.settings, outcome, {"reason": why})
    except BlockingIOError:
        return f"{folder}: is being written, and is left unchanged"
    except (OSError, RecordError, RunError) as error:
        return f"{folder / SUMMARY} is not made: {error}"
    return f"{folder / SUMMARY} and the other results are made from {RECORDING}"
