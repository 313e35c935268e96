"""Messages of any type with any content, and whether two libraries took the same for it."""

import re
from array import array
from importlib import import_module
from typing import Any

import numpy as np
from hypothesis import strategies as st

INTEGERS = {f"{sign}int{bits}": bits for sign in ("", "u") for bits in (8, 16, 32, 64)}
FEW = 3
"""Most elements of a sequence."""


def messages(kind: type) -> st.SearchStrategy:
    """Messages of a class, every field of them drawn."""
    fields = {name: _values(text) for name, text in kind.get_fields_and_field_types().items()}
    return st.fixed_dictionaries(fields).map(lambda values: _filled(kind, values))


def _filled(kind: type, values: dict[str, Any]) -> Any:
    message = kind()
    for name, value in values.items():
        setattr(message, name, value)
    return message


def _values(text: str) -> st.SearchStrategy:
    sequence = re.fullmatch(r"sequence<(\S+?)(?:, \d+)?>", text)
    if sequence:
        return st.lists(_values(sequence[1]), max_size=FEW)
    fixed = re.fullmatch(r"(.+)\[(\d+)\]", text)
    if fixed:
        return st.lists(_values(fixed[1]), min_size=int(fixed[2]), max_size=int(fixed[2]))
    return _single(text)


def _single(text: str) -> st.SearchStrategy:
    if text in INTEGERS:
        bits, unsigned = INTEGERS[text], text.startswith("u")
        return st.integers(0 if unsigned else -(2 ** (bits - 1)), 2 ** (bits if unsigned else bits - 1) - 1)
    simple = {
        "boolean": st.booleans(),
        "octet": st.binary(min_size=1, max_size=1),
        "float": st.floats(width=32, allow_nan=False),
        "double": st.floats(allow_nan=False),
        "string": st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=20),
    }
    if text in simple:
        return simple[text]
    package, name = text.split("/")
    return messages(getattr(import_module(f"{package}.msg"), name))


def plain(message: Any, kind: type) -> Any:
    """The content of a message that any library has made, by the fields of the class `kind`."""
    return {name: _plain(getattr(message, name), text) for name, text in kind.get_fields_and_field_types().items()}


def _plain(value: Any, text: str) -> Any:
    inner = re.fullmatch(r"sequence<(\S+?)(?:, \d+)?>|(.+)\[\d+\]", text)
    if inner:
        elements = list(value) if isinstance(value, (array, bytes)) else value
        return [_plain(each, inner[1] or inner[2]) for each in elements]
    if "/" in text:
        package, name = text.split("/")
        return plain(value, getattr(import_module(f"{package}.msg"), name))
    if text == "octet":
        return value[0] if isinstance(value, bytes) else int(value)
    return value.item() if isinstance(value, np.generic) else value
