"""Numbers drawn for a seeded world, the same on every machine and with every version of numpy."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

# only `random()` of the generator: its stream is the one thing no numpy version has changed
Draw = Callable[[float, float], float]


def draws_of(*seed: int) -> Draw:
    """A function of low and high that draws uniformly between them, from a stream of its own per seed."""
    bits = np.random.PCG64(seed[0] if len(seed) == 1 else seed)
    return partial(_uniform, np.random.Generator(bits))


def rounded(values: Sequence[Any] | np.ndarray) -> np.ndarray:
    """Coordinates [m] to a tenth of a millimetre."""
    # the last bits of cos and sin differ between machines, the world must not
    return np.round(np.array(values), 4)


def _uniform(generator: np.random.Generator, low: float, high: float) -> float:
    return low + (high - low) * float(generator.random())
