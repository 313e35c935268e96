"""What runs in a worker: a few trials at a time."""

import os
import signal
import threading
from collections.abc import Sequence
from functools import cache
from multiprocessing import parent_process
from time import perf_counter
from typing import Any

from collplan_core.warm_up import warm_up
from collplan_study.question.grid import Task
from collplan_study.tables.rows import NO_PATH, error_measures, impact_rows, measures, sampled_path
from omnipuck_sim.trial import run_trial

Record = dict[str, Any]
"""index, row (every column by name), path and impacts of one trial, as JSON holds them."""


def run_batch(tasks: Sequence[Task]) -> list[Record]:
    """Runs trials one after the other; one that raises becomes a row that says so."""
    _warm_up_once()
    return [run_task(task) for task in tasks]


def run_task(task: Task) -> Record:
    """Runs one trial."""
    begun = perf_counter()
    try:
        result = run_trial(task.world, task.settings, task.seed)
        measured, path = measures(result, perf_counter() - begun), sampled_path(result.trajectory)
        impacts = impact_rows(result)
    except Exception as error:
        measured, path, impacts = error_measures(error), NO_PATH, []
    return {"index": task.index, "row": {**task.labels, **measured}, "path": path, "impacts": impacts}


@cache
def _warm_up_once() -> None:
    # in whatever process this is; else the first trial's planning times would hold it
    warm_up()


def enter_worker() -> None:
    """Leaves Ctrl-C to the study, and ends when the study does, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
