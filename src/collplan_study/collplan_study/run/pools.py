"""Where the trials run: in this process, in several, or on a Dask cluster."""

import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from collplan_study.run.worker import enter_worker

Pool = tuple[Executor, int]
"""An executor and the number of its workers."""


def open_pool(jobs: int, dask: str | None) -> AbstractContextManager[Pool]:
    """The Dask cluster at an address if one is given, else `jobs` processes.

    Raises:
        StudyError: on entering, when the cluster cannot be used.
    """
    if dask is not None:
        from collplan_study.run.dask_pool import dask_pool

        return dask_pool(dask)
    return _in_this_process() if jobs == 1 else _in_processes(jobs)


class InThisProcess(Executor):
    """Runs what is submitted at once."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """A future that has its result; what the call raises is raised here."""
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


@contextmanager
def _in_this_process() -> Iterator[Pool]:
    yield InThisProcess(), 1


@contextmanager
def _in_processes(jobs: int) -> Iterator[Pool]:
    # one server imports everything once; the workers are forked from it, before it has any thread
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["collplan_study.run.worker"])
    executor = ProcessPoolExecutor(jobs, mp_context=context, initializer=enter_worker)
    try:
        yield executor, jobs
    finally:
        executor.shutdown(cancel_futures=True)
