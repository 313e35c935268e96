"""Trials in a pool of workers, a bounded number of batches at a time: this process, several, or a Dask cluster."""

import logging
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from functools import cache
from itertools import islice
from time import perf_counter
from typing import Any

from tqdm import tqdm

from collplan_core.warm_up import warm_up
from collplan_study.errors import StudyError, WorkersLost
from collplan_study.question.grid import Task
from collplan_study.run.provenance import trial_code
from collplan_study.run.rows import NO_PATH, TrialRow, error_measures, impact_rows, measures, sampled_path
from omnipuck_sim.trial import run_trial

Pool = tuple[Executor, int]
"""An executor and its number of workers."""
PATIENCE = 10.0
"""Time within which a Dask scheduler must answer [s]."""
BATCH, QUEUED = 4, 2
"""Trials in a batch, some tenths of a second of work and one write to the disk, and batches submitted for a worker."""
CODE = trial_code()
"""Of what this process runs: taken at the import, as the files may change later."""
# once in every process; else the first trial's planning times would include compiling
warm_up_once = cache(warm_up)


def run_batch(tasks: Sequence[Task]) -> list[TrialRow]:
    """Runs trials one after the other; one that raises becomes a row with its error."""
    warm_up_once()
    return [_run_task(task) for task in tasks]


def _run_task(task: Task) -> TrialRow:
    started_at = perf_counter()
    try:
        result = run_trial(task.world, task.settings, task.seed)
        measured, path = measures(result, perf_counter() - started_at), sampled_path(result.trajectory)
        impacts = impact_rows(result)
    except Exception as error:
        measured, path, impacts = error_measures(error), NO_PATH, []
    return {"index": task.index, "code": CODE, "row": {**task.labels, **measured}, "path": path, "impacts": impacts}


def enter_worker() -> None:
    """Prepares a worker process: it ignores Ctrl-C, which the study handles, and exits with the study's process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_exit_with_parent, daemon=True).start()


def _exit_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


class InThisProcess(Executor):
    """Executor that runs a call at once, in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """A future that is already done. What the call raises is raised here."""
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


@contextmanager
def open_pool(jobs: int, dask: str | None) -> Iterator[Pool]:
    """Context of the pool that trials run in: the Dask cluster at address `dask` if given, else `jobs` processes."""
    if dask is not None:
        yield from _on_cluster(dask)
    elif jobs == 1:
        yield InThisProcess(), 1
    else:
        # the fork server imports everything once; workers are forked from it before it has any thread
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(["collplan_study.run.pools"])
        executor = ProcessPoolExecutor(jobs, mp_context=context, initializer=enter_worker)
        try:
            yield executor, jobs
        finally:
            executor.shutdown(cancel_futures=True)


def _on_cluster(address: str) -> Iterator[Pool]:
    # imported late: it takes a second, and few studies need it
    from distributed import Client

    # a scheduler that dies is said in a sentence of the study's own
    for name in ("distributed", "distributed.client"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError, TypeError) as error:
        raise StudyError(f"--dask {address}: no scheduler answers there ({type(error).__name__}: {error})") from None
    with client:
        workers = sum(client.ncores().values())
        if not workers:
            raise StudyError(f"--dask {address}: the scheduler has no workers")
        yield client.get_executor(pure=False), workers


def run_tasks(tasks: Iterable[Task], pool: Pool, code: str) -> Iterator[list[TrialRow]]:
    """The records of each batch as it is completed, in no order; WorkersLost where a worker has other code, too."""
    (executor, workers), remaining = pool, iter(tasks)
    batches = iter(lambda: tuple(islice(remaining, BATCH)), ())
    pending: set[Future[list[TrialRow]]] = set()
    try:
        while True:
            pending |= {executor.submit(run_batch, batch) for batch in islice(batches, QUEUED * workers - len(pending))}
            if not pending:
                return
            done, pending = wait(pending, return_when=FIRST_COMPLETED)
            for rows in (future.result() for future in done):
                for found in {row.get("code") for row in rows} - {code}:
                    joined = f"a worker with other code or libraries ({found}) has joined"
                    raise WorkersLost(f"{joined}, here is {code}: end it")
                yield rows
    except WorkersLost:
        raise
    except Exception as error:
        # run_batch catches what a trial raises: any error left is the executor's
        said = f"{type(error).__name__}: {error}".removesuffix(": ")
        raise WorkersLost(f"workers, or the scheduler of their cluster, are gone ({said})") from error


def progress_bar(total: int, done: int, unit: str) -> tqdm:
    """A bar on standard error of how many are done, of a unit such as "trial"; every 30 s where nobody watches."""
    period = 0.5 if sys.stderr.isatty() else 30.0
    return tqdm(total=total, initial=done, unit=unit, mininterval=period, maxinterval=2.0 * period)
