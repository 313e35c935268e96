"""Checks of what a program gives: an error names the argument, the value and what was expected."""

from typing import Any

import numpy as np

Shape = tuple[int | None, ...]


def finite(key: str, value: Any, shape: Shape, form: str, error: type[ValueError] = ValueError) -> np.ndarray:
    """A copy of a value as finite numbers of this shape, None for any length; an error that ends with the form else."""
    try:
        array = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise error(f"{key}: got {value!r:.80}, {form}") from None
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape, strict=True)):
        shown = f"shape {array.shape}" if array.size > 9 else array.tolist() if array.ndim else value
        raise error(f"{key}: got {shown}, {form}")
    for row in np.argwhere(~np.isfinite(array))[:, :1].tolist():
        raise error(f"{key}{row or ''}: got {array[tuple(row)].tolist()}, {form}")
    return array


def rising(key: str, times: Any, error: type[ValueError] = ValueError) -> np.ndarray:
    """Times (n,) [s] as `finite` gives them, at least 2, each later than the one before; an error else."""
    array = finite(key, times, (None,), "expected finite times (n,) [s]", error)
    if len(array) < 2:
        raise error(f"{key}: got {len(array)}, expected at least 2")
    for i in np.flatnonzero(np.diff(array) <= 0.0):
        raise error(f"{key}[{i + 1}]: got time {array[i + 1]} after {array[i]}, expected a later one")
    return array


def check_type(key: str, value: Any, kind: type, hint: str = "") -> None:
    """Raises TypeError where a value is not of a type."""
    if not isinstance(value, kind):
        raise TypeError(f"{key}: got {value!r:.80}, expected {kind.__name__}{hint}")
