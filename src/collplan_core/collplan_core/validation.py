"""Checks of what a program gives: an error names the argument, the value and what was expected."""

from types import UnionType
from typing import Any

import numpy as np

Shape = tuple[int | None, ...]
"""Length of each axis, None for any."""


def finite(key: str, value: Any, shape: Shape, form: str, error: type[ValueError] = ValueError) -> np.ndarray:
    """Returns a copy of a value as an array of finite numbers of this shape.

    Raises:
        ValueError: of the type `error`; it is something else. The message begins with the key and ends with the form.
    """
    try:
        array = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise error(f"{key}: got {value!r:.80}, {form}") from None
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape, strict=True)):
        shown = f"shape {array.shape}" if array.size > 9 else array.tolist() if array.ndim else value
        raise error(f"{key}: got {shown}, {form}")
    wrong = np.argwhere(~np.isfinite(array))
    if len(wrong):
        row = wrong[0, 0]
        raise error(f"{key}[{row}]: got {array[row].tolist()}, {form}")
    return array


def rising(key: str, times: Any, error: type[ValueError] = ValueError) -> np.ndarray:
    """Returns a copy of times (n,) [s], n at least 2, each later than the one before.

    Raises:
        ValueError: of the type `error`; they are something else.
    """
    array = finite(key, times, (None,), "expected finite times (n,) [s]", error)
    if len(array) < 2:
        raise error(f"{key}: got {len(array)}, expected at least 2")
    early = np.flatnonzero(np.diff(array) <= 0.0)
    if len(early):
        i = early[0]
        raise error(f"{key}[{i + 1}]: got time {array[i + 1]} after {array[i]}, expected a later one")
    return array


def check_type(key: str, value: Any, kind: type | UnionType, hint: str = "") -> None:
    """Raises TypeError where a value is not of a type."""
    if not isinstance(value, kind):
        name = getattr(kind, "__name__", str(kind))
        raise TypeError(f"{key}: got {value!r:.80}, expected {name}{hint}")
