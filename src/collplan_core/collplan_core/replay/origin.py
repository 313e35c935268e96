"""Origin of a journal: the same code on the same machine decides the same to the last bit, another may not."""

import platform
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numba
import numpy as np

from collplan_core.jit import sources_digest

PROCESSORS = Path("/proc/cpuinfo")


@cache
def origin() -> dict[str, str]:
    """Code and machine of this process, by name."""
    return {
        "code": sources_digest() + (", not compiled" if numba.config.DISABLE_JIT else ""),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": version("numba"),
        "scipy": version("scipy"),
        "shapely": version("shapely"),
        "processor": _processor(),
    }


def _processor() -> str:
    """The processor's model, of which compiled code makes use, or at least its kind."""
    try:
        models = [line for line in PROCESSORS.read_text().splitlines() if line.startswith("model name")]
    except OSError:
        models = []
    return models[0].partition(":")[2].strip() if models else platform.machine()


def changes(made_with: Mapping[str, object]) -> list[str]:
    """Returns the differences from a journal's origin, each as `numpy 1.26.4 then, 2.1.0 now`."""
    others = {name: now for name, now in origin().items() if made_with.get(name) != now}
    return [f"{name} {made_with.get(name)} then, {now} now" for name, now in others.items()]
