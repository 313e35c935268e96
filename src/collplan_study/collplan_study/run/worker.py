"""Code of the worker processes: a batch of trials at a time."""

import os
import signal
import threading
from collections.abc import Sequence
from functools import cache
from multiprocessing import parent_process
from time import perf_counter

from collplan_core.warm_up import warm_up
from collplan_study.question.grid import Task
from collplan_study.run.provenance import trial_code
from collplan_study.run.rows import NO_PATH, TrialRow, error_measures, impact_rows, measures, sampled_path
from omnipuck_sim.trial import run_trial

CODE = trial_code()
"""Of what this process runs: taken at the import, as the files may change later."""
# once in every process; else the first trial's planning times would include compiling
_warm_up_once = cache(warm_up)


def run_batch(tasks: Sequence[Task]) -> list[TrialRow]:
    """Runs trials one after the other; one that raises becomes a row with its error."""
    _warm_up_once()
    return [_run_task(task) for task in tasks]


def _run_task(task: Task) -> TrialRow:
    started_at = perf_counter()
    try:
        result = run_trial(task.world, task.settings, task.seed)
        measured, path = measures(result, perf_counter() - started_at), sampled_path(result.trajectory)
        impacts = impact_rows(result)
    except Exception as error:
        measured, path, impacts = error_measures(error), NO_PATH, []
    row = {**task.labels, **measured}
    return {"index": task.index, "code": CODE, "row": row, "path": path, "impacts": impacts}


def enter_worker() -> None:
    """Prepares a worker process: it ignores Ctrl-C, which the study handles, and exits with the study's process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_exit_with_parent, daemon=True).start()


def _exit_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
