"""Pools of workers for the trials: this process, several processes, or a Dask cluster."""

import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from collplan_study.run.worker import enter_worker

Pool = tuple[Executor, int]
"""An executor and its number of workers."""


def open_pool(jobs: int, dask: str | None) -> AbstractContextManager[Pool]:
    """Context of the pool that trials run in: the Dask cluster at address `dask` if given, else `jobs` processes.

    Raises:
        StudyError: on entering, when the cluster cannot be used.
    """
    if dask is not None:
        from collplan_study.run.dask_pool import dask_pool

        return dask_pool(dask)
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
