"""Inputs of the loops, as JSON and back, every float bit for bit.

A finite float is the number that Python prints, which reads back to the same bits. A value that JSON does not have is
an object with one key:

| key | value |
|---|---|
| `float` | `nan`, `inf` or `-inf` |
| `bytes` | hexadecimal digits |
| `array` | shape, and base64 of little-endian float64 |
| `state` | stamp, and base64 of x, y, vx, vy, yaw as such |
| `goal` | identity, stamp, position, status |
| `settings` | every parameter by its key |
| `scan` | numbers, and the array of ranges |
| `plan` | stamp, the arrays of times, positions and velocities, its end of validity; the controller reads no more |
"""

import math
import struct
from base64 import b64decode, b64encode
from collections.abc import Callable
from typing import Any

import numpy as np

from collplan_core.goal import Goal
from collplan_core.parameters import Settings
from collplan_core.plan import Plan, plan_of_path
from collplan_core.scan import Scan
from collplan_core.state import State

_MOTION = struct.Struct("<5d")


class JournalError(ValueError):
    """Error of a journal that cannot be read; the message names what was found and what was expected."""


def encode(value: Any) -> Any:
    """A value as JSON.

    Raises:
        TypeError: it is of a kind that no loop takes.
    """
    if value is None or isinstance(value, bool | str | int):
        return value
    if isinstance(value, float):
        # a numpy float is one of Python's to json; its own repr is not asked
        return value if math.isfinite(value) else {"float": str(float(value))}
    if isinstance(value, list | tuple):
        return [encode(each) for each in value]
    return _tagged(value)


def _tagged(value: Any) -> dict[str, Any]:
    if isinstance(value, State):
        motion = _MOTION.pack(*value.position.tolist(), *value.velocity.tolist(), value.yaw)
        return {"state": [value.stamp, b64encode(motion).decode()]}
    if isinstance(value, np.ndarray):
        return {"array": [list(value.shape), b64encode(little_endian(value)).decode()]}
    if isinstance(value, Scan):
        beams = [value.stamp, value.angle_min, value.angle_increment, value.range_min, value.range_max]
        return {"scan": encode([*beams, value.ranges, value.time_increment])}
    if isinstance(value, Plan):
        return {"plan": encode([value.stamp, value.times, value.positions, value.velocities, value.valid_until])}
    if isinstance(value, Goal):
        return {"goal": encode([value.id, value.stamp, value.position, value.status])}
    if isinstance(value, bytes):
        return {"bytes": value.hex()}
    if isinstance(value, Settings):
        return {"settings": {key: encode(each) for key, each in value.values().items()}}
    raise TypeError(f"a journal holds no {type(value).__name__}")


def little_endian(array: np.ndarray) -> bytes:
    """The bytes of an array as little-endian float64, row by row; every NaN is the same one."""
    numbers = np.array(array, dtype="<f8")
    unknown = np.isnan(numbers)
    if unknown.any():
        numbers[unknown] = np.nan
    return numbers.tobytes()


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
    tag, held = next(iter(value.items())) if len(value) == 1 else ("", None)
    if tag not in _DECODERS:
        raise JournalError(f"got {value!s:.80}, expected an object with one key, one of {', '.join(_DECODERS)}")
    try:
        return _DECODERS[tag](held)
    except (TypeError, ValueError, struct.error) as error:
        raise JournalError(f"{tag}: got {held!s:.80} ({error})") from None


def _state(held: Any) -> State:
    stamp, motion = held
    x, y, vx, vy, yaw = _MOTION.unpack(b64decode(motion))
    return State(stamp, np.array([x, y]), np.array([vx, vy]), yaw)


def _array(held: Any) -> np.ndarray:
    shape, numbers = held
    return np.frombuffer(b64decode(numbers), dtype="<f8").astype(np.float64).reshape(shape)


_DECODERS: dict[str, Callable[[Any], Any]] = {
    "float": float,
    "bytes": bytes.fromhex,
    "array": _array,
    "state": _state,
    "goal": lambda held: Goal(*decode(held)),
    "settings": lambda held: Settings().with_values({key: decode(each) for key, each in held.items()}),
    "scan": lambda held: Scan(*decode(held)),
    "plan": lambda held: plan_of_path(*decode(held)),
}
