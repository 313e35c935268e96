"""What a journal holds, inputs of the loops and what comes of them, as JSON and back, every float bit for bit.

A finite float is the number that Python prints, which reads back to the same bits. What JSON does not have is an
object with one key: `float` (nan, inf, -inf), `bytes` (hexadecimal digits), `array` (the numbers of a short one, or
shape, type and base64), `map`, `settings` (every parameter by its key), or a record by its name, with its fields. Of an
outcome only a hash of a long array is kept.
"""

import math
from base64 import b64decode, b64encode
from collections.abc import Callable, Mapping
from dataclasses import fields
from hashlib import blake2b
from typing import Any

import numpy as np

from collplan_core.command import Command
from collplan_core.goal import Goal
from collplan_core.loop.decisions import Cycle, Notice
from collplan_core.parameters import Settings
from collplan_core.parameters.groups import is_without_effect
from collplan_core.plan import Candidates, Contacts, Plan
from collplan_core.scan import Scan
from collplan_core.state import State

SHORT = 4
"""Arrays of no more numbers are written as numbers."""
RECORDS: dict[str, type[Any]] = {
    kind.__name__.lower(): kind for kind in (State, Scan, Plan, Contacts, Goal, Command, Notice)
}
NOTHING = Candidates(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
"""In the place of a plan's candidates, which are for display alone."""
LATER = "drive"
"""Field that journals of earlier versions do not have; left out where it says nothing."""
_FIELDS = {
    kind: (name, tuple(field.name for field in fields(kind) if field.name != "candidates"))
    for name, kind in RECORDS.items()
}


class JournalError(ValueError):
    """Error of a journal that cannot be read; the message names what was found and what was expected."""


def encode(value: Any, hashed: bool = False) -> Any:
    """A value as JSON; long arrays as hashes where `hashed`.

    Raises:
        TypeError: it is of a kind that no loop takes or returns.
    """
    if value is None or isinstance(value, bool | str | int):
        return value
    if isinstance(value, float):
        # a numpy float is one of Python's to json; its own repr is not asked
        return value if math.isfinite(value) else {"float": str(float(value))}
    if isinstance(value, list | tuple):
        return [encode(each, hashed) for each in value]
    if isinstance(value, np.ndarray):
        return {"array": _numbers(value, hashed)}
    if isinstance(value, Cycle):
        return encode(value.plan, hashed)
    if type(value) in _FIELDS:
        name, names = _FIELDS[type(value)]
        held = {each: getattr(value, each) for each in names}
        return {name: {each: encode(held[each], hashed) for each in names if each != LATER or held[each] is not None}}
    return _rare(value, hashed)


def outcome_of(value: Any) -> Any:
    """The outcome of a call from what the loop returned, or the error that it raised; None for nothing.

    Raises:
        TypeError: no loop returns such a thing.
    """
    return encode(value, hashed=True) or None


def _rare(value: Any, hashed: bool) -> Any:
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, bytes):
        return {"bytes": value.hex()}
    if isinstance(value, Mapping):
        return {"map": {key: encode(each, hashed) for key, each in value.items()}}
    if isinstance(value, Settings):
        return {"settings": {key: encode(each) for key, each in value.values().items()}}
    if isinstance(value, Exception):
        return {"raised": f"{type(value).__name__}: {value}"}
    raise TypeError(f"a journal holds no {type(value).__name__}")


def _numbers(array: np.ndarray, hashed: bool) -> list[Any]:
    numbers = np.array(array, dtype="<f8")  # row by row
    numbers[np.isnan(numbers)] = np.nan  # every NaN is the same one
    if numbers.ndim == 1 and len(numbers) <= SHORT:
        return [encode(each) for each in numbers.tolist()]
    shape = list(numbers.shape)
    if hashed:
        return [shape, "hash", blake2b(numbers.tobytes(), digest_size=8).hexdigest()]
    with np.errstate(over="ignore"):
        single = numbers.astype("<f4")  # the ranges of a message are no longer
    if np.array_equal(single, numbers, equal_nan=True):
        return [shape, "f4", b64encode(single.tobytes()).decode()]
    return [shape, "f8", b64encode(numbers.tobytes()).decode()]


def decode(value: Any) -> Any:
    """The value of `encode`; a list where that was given a tuple.

    Raises:
        JournalError: it is of no form that `encode` gives.
        ParameterError: settings with a parameter that is not known here.
    """
    if isinstance(value, list):
        return [decode(each) for each in value]
    if not isinstance(value, dict):
        return value
    tag, held = next(iter(value.items())) if len(value) == 1 else ("", {})
    try:
        if tag in _DECODERS:
            return _DECODERS[tag](held)
        if tag in RECORDS:
            given = {name: decode(each) for name, each in held.items()}
            return RECORDS[tag](**given, **({"candidates": NOTHING} if tag == "plan" else {}))
    except (AttributeError, TypeError, ValueError) as error:
        raise JournalError(f"{tag}: got {held!s:.80} ({error})") from None
    raise JournalError(
        f"got {value!s:.80}, expected an object with one key, one of {', '.join((*_DECODERS, *RECORDS))}"
    )


def _array(held: Any) -> np.ndarray:
    if len(held) == 3 and isinstance(held[1], str):
        shape, kind, numbers = held
        return np.frombuffer(b64decode(numbers), dtype=f"<{kind}").astype(np.float64).reshape(shape)
    return np.array(decode(held), dtype=np.float64)


def _settings(held: Any) -> Settings:
    return Settings().with_values({key: decode(each) for key, each in held.items() if not is_without_effect(key)})


_DECODERS: dict[str, Callable[[Any], Any]] = {
    "float": float,
    "bytes": bytes.fromhex,
    "array": _array,
    "map": lambda held: {key: decode(each) for key, each in held.items()},
    "settings": _settings,
}
