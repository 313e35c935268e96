"""Messages of any type with any content, and what of it a library has read."""

import re
import struct
from array import array
from importlib import import_module
from random import Random
from typing import Any

import numpy as np

INTEGERS = {f"{sign}int{bits}": bits for sign in ("", "u") for bits in (8, 16, 32, 64)}
FEW = 3
"""Most elements of a sequence."""
LETTERS = "aZ0_/ \n\"'\\äλ漢😀"


def any_message(kind: type, chance: Random) -> Any:
    """A message of a class with every field of it drawn."""
    message = kind()
    for name, text in kind.get_fields_and_field_types().items():
        setattr(message, name, _any_value(text, chance))
    return message


def _any_value(text: str, chance: Random) -> Any:
    inner, count = _elements(text)
    if inner:
        return [_any_value(inner, chance) for _ in range(chance.randint(0, FEW) if count is None else count)]
    if "/" in text:
        return any_message(_class(text), chance)
    if text in INTEGERS:
        bits = INTEGERS[text]
        number = chance.getrandbits(bits)
        return number if text.startswith("u") else number - 2 ** (bits - 1)
    if text in ("float", "double"):
        number = chance.choice(
            [0.0, -0.0, float("inf"), float("-inf"), chance.gauss(0.0, 1e3), chance.gauss(0.0, 1e-9)]
        )
        return struct.unpack("<f", struct.pack("<f", number))[0] if text == "float" else number
    simple = {
        "boolean": lambda: chance.random() < 0.5,
        "octet": lambda: chance.randbytes(1),
        "string": lambda: "".join(chance.choices(LETTERS, k=chance.randint(0, 12))),
    }
    return simple[text]()


def plain(message: Any, kind: type) -> Any:
    """The content of a message that any library has made, by the fields of the class `kind`."""
    return {name: _plain(getattr(message, name), text) for name, text in kind.get_fields_and_field_types().items()}


def _plain(value: Any, text: str) -> Any:
    inner, _ = _elements(text)
    if inner:
        return [_plain(each, inner) for each in (list(value) if isinstance(value, (array, bytes)) else value)]
    if "/" in text:
        return plain(value, _class(text))
    if text == "octet":  # a byte is an integer to some, with or without a sign
        return value[0] if isinstance(value, bytes) else int(value) & 0xFF
    return value.item() if isinstance(value, np.generic) else value


def _elements(text: str) -> tuple[str, int | None]:
    """Type and, where that is fixed, number of the elements of a sequence; no type where it is none."""
    if sequence := re.fullmatch(r"sequence<(\S+?)(?:, \d+)?>", text):
        return sequence[1], None
    if fixed := re.fullmatch(r"(.+)\[(\d+)\]", text):
        return fixed[1], int(fixed[2])
    return "", None


def _class(text: str) -> type:
    package, name = text.split("/")
    return getattr(import_module(f"{package}.msg"), name)
