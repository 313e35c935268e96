"""Submits the trials to an executor in batches, a bounded number at a time, and shows how many are done."""

import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from itertools import islice

from tqdm import tqdm

from collplan_study.errors import WorkersLost
from collplan_study.question.grid import Task
from collplan_study.run.worker import run_batch
from collplan_study.tables.rows import TrialRow

BATCH = 4
"""Trials in a batch: some tenths of a second of work, and one write to the disk."""
QUEUED = 2
"""Batches submitted for each worker."""


def run_tasks(tasks: Iterable[Task], executor: Executor, workers: int, code: str) -> Iterator[list[TrialRow]]:
    """The records of each batch as it is completed, in no order. Memory does not grow with the number of tasks.

    Raises:
        WorkersLost: the executor broke, or a worker has other code than `code`: one may join at any time.
    """
    remaining = iter(tasks)
    batches = iter(lambda: tuple(islice(remaining, BATCH)), ())
    pending = _submitted(executor, islice(batches, QUEUED * workers))
    while pending:
        done, pending = wait(pending, return_when=FIRST_COMPLETED)
        for future in done:
            yield _of_code(_result(future), code)
        pending |= _submitted(executor, islice(batches, len(done)))


def _submitted(executor: Executor, batches: Iterable[tuple[Task, ...]]) -> set[Future[list[TrialRow]]]:
    try:
        return {executor.submit(run_batch, batch) for batch in batches}
    except BrokenExecutor as error:
        raise _lost(error) from error


def _result(future: Future[list[TrialRow]]) -> list[TrialRow]:
    try:
        return future.result()
    except Exception as error:
        # run_batch catches what a trial raises: any error left is the executor's
        raise _lost(error) from error


def _of_code(rows: list[TrialRow], code: str) -> list[TrialRow]:
    for row in rows:
        if (found := row.get("code")) != code:
            raise WorkersLost(f"a worker with other code or libraries ({found}) has joined, here is {code}: end it")
    return rows


def _lost(error: Exception) -> WorkersLost:
    said = f": {error}" if str(error) else ""
    return WorkersLost(f"workers, or the scheduler of their cluster, are gone ({type(error).__name__}{said})")


def progress_bar(total: int, done: int, unit: str) -> tqdm:
    """A bar on standard error of how many are done, of a unit such as "trial"; every 30 s where nobody watches."""
    period = 0.5 if sys.stderr.isatty() else 30.0
    return tqdm(total=total, initial=done, unit=unit, mininterval=period, maxinterval=2.0 * period)
