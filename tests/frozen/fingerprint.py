"""Fingerprints of results: a digest for equality to the last bit, and sums for equality to 1e-9."""

import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

TOLERANCE = 1e-9
"""Largest difference of a number between two processors, relative for numbers above 1."""


def fingerprint(content: Any) -> dict[str, Any]:
    """Fingerprint of nested mappings, sequences, arrays, numbers and texts.

    Returns:
        `digest` over every bit and text, `texts` over the texts alone, the `count` of numbers, their `sum`, and `ramp`:
        the sum of each number times its place, from 0 to 1, which notices an exchange.
    """
    numbers, texts = list[float](), list[str]()
    for value in _leaves(content):
        if isinstance(value, str):
            texts.append(value)
        else:
            numbers.append(float(value))
    values = np.array(numbers)
    finite = np.where(np.isfinite(values), values, 0.0)
    words = json.dumps(texts).encode()
    return {
        "digest": hashlib.sha256(values.tobytes() + words).hexdigest()[:16],
        "texts": hashlib.sha256(words).hexdigest()[:16],
        "count": len(numbers),
        "sum": math.fsum(finite),
        "ramp": math.fsum(finite * np.linspace(0.0, 1.0, len(finite))),
    }


def is_same(frozen: Mapping[str, Any], found: Mapping[str, Any]) -> bool:
    """Returns whether two fingerprints are of equal results, or of results within TOLERANCE."""
    if frozen["digest"] == found["digest"]:
        return True
    alike = all(frozen[key] == found[key] for key in ("texts", "count"))
    return alike and all(
        math.isclose(frozen[key], found[key], rel_tol=TOLERANCE, abs_tol=TOLERANCE) for key in ("sum", "ramp")
    )


def _leaves(content: Any) -> Iterator[float | str]:
    if isinstance(content, str):
        yield content
    elif content is None:
        yield "none"
    elif isinstance(content, Mapping):
        for key in sorted(content):
            yield str(key)
            yield from _leaves(content[key])
    elif isinstance(content, np.ndarray):
        yield from np.asarray(content, dtype=float).ravel().tolist()
    elif isinstance(content, Sequence):
        for each in content:
            yield from _leaves(each)
    else:
        yield content
