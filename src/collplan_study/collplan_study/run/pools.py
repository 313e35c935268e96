"""Pools of workers for the trials: this process, several processes, or a Dask cluster."""

import logging
import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from collplan_study.errors import StudyError
from collplan_study.run.provenance import trial_code
from collplan_study.run.worker import enter_worker

Pool = tuple[Executor, int]
"""An executor and its number of workers."""
PATIENCE = 10.0
"""Time within which a Dask scheduler must answer [s]."""


def open_pool(jobs: int, dask: str | None) -> AbstractContextManager[Pool]:
    """Context of the pool that trials run in: the Dask cluster at address `dask` if given, else `jobs` processes.

    Raises:
        StudyError: on entering, when the cluster cannot be used.
    """
    if dask is not None:
        return _on_cluster(dask)
    return _in_this_process() if jobs == 1 else _in_processes(jobs)


class InThisProcess(Executor):
    """Executor that runs a call at once, in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """A future that is already done. What the call raises is raised here."""
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


@contextmanager
def _in_this_process() -> Iterator[Pool]:
    yield InThisProcess(), 1


@contextmanager
def _in_processes(jobs: int) -> Iterator[Pool]:
    # the fork server imports everything once; workers are forked from it before it has any thread
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["collplan_study.run.worker"])
    executor = ProcessPoolExecutor(jobs, mp_context=context, initializer=enter_worker)
    try:
        yield executor, jobs
    finally:
        executor.shutdown(cancel_futures=True)


@contextmanager
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
        _check_code(client.run, address)
        yield client.get_executor(pure=False), sum(client.ncores().values())


def _check_code(run: Callable[..., dict[str, str]], address: str) -> None:
    """Refuses workers with other code than this process; `run` calls a function in each."""
    own_code = trial_code()
    try:
        codes = run(trial_code)
    except Exception as error:
        # whatever a worker raises, most likely an import error: the project is not installed there
        raise StudyError(f"--dask {address}: a worker cannot run trials ({type(error).__name__}: {error})") from None
    if not codes:
        raise StudyError(f"--dask {address}: the scheduler has no workers")
    for worker, code in codes.items():
        if code != own_code:
            raise StudyError(f"--dask {address}: worker {worker} has other code: {code}, here {own_code}")
