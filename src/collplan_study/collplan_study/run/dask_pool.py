"""A Dask cluster as an executor."""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from distributed import Client

from collplan_study.errors import StudyError
from collplan_study.run.code_state import trial_code

PATIENCE = 10.0
"""The scheduler must answer within this time [s]."""


@contextmanager
def dask_pool(address: str) -> Iterator[tuple[Executor, int]]:
    """An executor on the cluster whose scheduler is at `address`, and the number of its threads.

    Raises:
        StudyError: no scheduler there, no workers, or workers whose code is not the code here.
    """
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError, TypeError) as error:
        raise StudyError(f"--dask {address}: no scheduler answers there ({_line(error)})") from None
    try:
        _check_code(client, address)
        yield client.get_executor(pure=False), sum(client.ncores().values())
    finally:
        client.close()


def _check_code(client: Client, address: str) -> None:
    here = trial_code()
    try:
        there = client.run(trial_code)
    except Exception as error:
        # whatever a worker raises: it has not the packages of the project
        raise StudyError(f"--dask {address}: a worker cannot run trials ({_line(error)})") from None
    if not there:
        raise StudyError(f"--dask {address}: the scheduler has no workers")
    for worker, code in there.items():
        if code != here:
            raise StudyError(f"--dask {address}: worker {worker} has other code: {code}, here {here}")


def _line(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
