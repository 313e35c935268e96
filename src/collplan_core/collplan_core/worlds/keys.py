"""Keys of YAML files that describe worlds, and their values."""

from collections.abc import Mapping
from difflib import get_close_matches
from typing import Any

from collplan_core.worlds.shapes import BOUNDS_FORM, WorldError


def check_keys(mapping: Mapping[str, Any], known: tuple[str, ...], required: tuple[str, ...]) -> None:
    """Raises WorldError on a key that is not among those known, with the nearest one, and on one that is missing."""
    for key in mapping:
        if key not in known:
            near = get_close_matches(str(key), known, n=1)
            hint = f", did you mean {near[0]}?" if near else ""
            raise WorldError(f"{key}: unknown key, expected {', '.join(known)}{hint}")
    for key in required:
        if key not in mapping:
            raise WorldError(f"{key}: missing" + (f", {BOUNDS_FORM}" if key == "bounds" else ""))


def numbers(key: str, value: Any, count: int, form: str) -> list[float]:
    """The value of a key as so many numbers; WorldError with the expected form where it is none."""
    # yaml reads `true` as a bool, which Python would take for the number 1, and `1e3` as text
    if not isinstance(value, list) or len(value) != count or any(type(v) not in (int, float) for v in value):
        shown = value[0] if isinstance(value, list) and count == 1 else value
        raise WorldError(f"{key}: got {shown!r:.80}, {form}")
    return [float(v) for v in value]
