"""Runs trials on a Dask cluster."""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from distributed import Client

from collplan_study.errors import StudyError
from collplan_study.run.code_state import trial_code

PATIENCE = 10.0
"""Time within which the scheduler must answer [s]."""


@contextmanager
def dask_pool(address: str) -> Iterator[tuple[Executor, int]]:
    """An executor on the cluster whose scheduler is at `address`, and the number of its threads.

    Raises:
        StudyError: no scheduler there, no workers, or workers with other code than this process.
    """
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError, TypeError) as error:
        raise StudyError(f"--dask {address}: no scheduler answers there ({_one_line(error)})") from None
    try:
        _check_code(client, address)
        yield client.get_executor(pure=False), sum(client.ncores().values())
    finally:
        client.close()


def _check_code(client: Client, address: str) -> None:
    own_code = trial_code()
    try:
        codes = client.run(trial_code)
    except Exception as error:
        # whatever a worker raises, most likely an import error: the project is not installed there
        raise StudyError(f"--dask {address}: a worker cannot run trials ({_one_line(error)})") from None
    if not codes:
        raise StudyError(f"--dask {address}: the scheduler has no workers")
    for worker, code in codes.items():
        if code != own_code:
            raise StudyError(f"--dask {address}: worker {worker} has other code: {code}, here {own_code}")


def _one_line(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
