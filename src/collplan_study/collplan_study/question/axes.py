"""Axes of the grid, as --set gives them in text."""

from collections.abc import Sequence
from typing import Any

from collplan_core.parameters import all_specs, unknown_key
from collplan_core.parameters.spec import Spec
from collplan_study.errors import StudyError

OWN_OPTION = {
    "planner.strategy": "--strategies",
    "planner.map_period": "--map-periods",
    "simulator.engine": "--engine",
    "simulator.seed": "--seed",
    "simulator.world": "--worlds",
    "lidar.world": "--worlds",
}
"""Parameters that have an option of their own, which --set refuses."""


def parse_axes(texts: Sequence[str]) -> dict[str, tuple[Any, ...]]:
    """Values by parameter key, parsed from texts KEY=A,B,C and checked.

    Raises:
        StudyError: a text not of this form, a key or a value given twice, or a key that has an option of its own.
        ParameterError: an unknown key, or a value out of its range.
    """
    axes: dict[str, tuple[Any, ...]] = {}
    for text in texts:
        key, equals, values = text.partition("=")
        if not equals:
            raise StudyError(f"--set: got {text!r}, expected KEY=VALUE or KEY=A,B,C")
        if key in OWN_OPTION:
            raise StudyError(f"--set {key}: has an option of its own, expected {OWN_OPTION[key]}")
        if key not in all_specs():
            raise unknown_key(key)
        if key in axes:
            raise StudyError(f"--set {key}: given twice, expected one list {key}=A,B,C")
        axes[key] = _values(all_specs()[key], values)
    return axes


def _values(spec: Spec, text: str) -> tuple[Any, ...]:
    values = tuple(spec.checked(_converted(type(spec.default), item)) for item in text.split(","))
    if len(set(values)) < len(values):
        raise StudyError(f"--set {spec.key}: got {text}, expected each value once")
    return values


def _converted(kind: type, text: str) -> Any:
    """The text converted to the parameter's type; the text itself where it cannot be, which the check then refuses."""
    try:
        return {"true": True, "false": False}[text] if kind is bool else kind(text)
    except (KeyError, ValueError):
        return text
