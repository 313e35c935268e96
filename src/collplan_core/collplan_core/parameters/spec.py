"""The definition of one parameter, written once: default, doc, unit, range, live or not.

A parameter group is a frozen dataclass that derives from `Parameters` and whose fields are made by `parameter()`.
The same field feeds validation, the ROS declaration and the documentation.
"""

import math
from collections.abc import Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from difflib import get_close_matches
from functools import cache
from typing import Any, ClassVar

import numpy as np

_IN_WORDS = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "text",
    tuple: "a list of numbers",
}


class ParameterError(ValueError):
    """A parameter with an unknown key, a wrong type or a value out of range; the message names all of them."""


@dataclass(frozen=True)
class Spec:
    """One parameter; `key` is its ROS name, `group.field`."""

    key: str
    default: Any
    doc: str
    unit: str
    low: float | None
    high: float | None
    choices: Sequence[str]
    live: bool
    of_radius: float = 0.0
    """Radius of the robot that the default is for [m]: at its default it is scaled with robot.radius. 0: it is not."""

    @property
    def expected(self) -> str:
        """The values this parameter takes, in words."""
        if self.choices:
            return "one of " + ", ".join(self.choices)
        kind = _IN_WORDS[type(self.default)]
        low = "-inf" if self.low is None else f"{self.low:g}"
        high = "inf" if self.high is None else f"{self.high:g}"
        bounds = "" if self.low is None and self.high is None else f" in [{low}, {high}]"
        return kind + bounds + (f" {self.unit}" if self.unit else "")

    def checked(self, value: Any) -> Any:
        """`value` in the parameter's own type.

        Raises:
            ParameterError: wrong type, not finite, out of range or not among the choices.
        """
        if isinstance(value, np.generic):
            value = value.item()
        if isinstance(self.default, tuple):
            return self._checked_numbers(value)
        if value is False and "off" in self.choices:
            value = "off"  # as YAML reads it
        kind = type(self.default)
        right = type(value) is kind or (kind is float and type(value) is int)
        if not right or (kind is float and not math.isfinite(value)):
            raise self._error(value)
        if self.choices and value not in self.choices:
            raise self._error(value)
        if kind in (int, float) and (
            (self.low is not None and value < self.low) or (self.high is not None and value > self.high)
        ):
            raise self._error(value)
        return kind(value)

    def default_at(self, radius: float) -> Any:
        """The default for a robot of this radius [m], within the range."""
        if not self.of_radius:
            return self.default
        scaled = self.default * (radius / self.of_radius)
        return min(max(scaled, self.low or 0.0), math.inf if self.high is None else self.high)

    def _checked_numbers(self, value: Any) -> tuple[float, ...]:
        try:
            each = replace(self, default=0.0)
            return tuple(each.checked(number) for number in value)
        except (TypeError, ParameterError):
            raise self._error(value) from None

    def _error(self, value: Any) -> ParameterError:
        near = get_close_matches(str(value), self.choices, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        return ParameterError(f"{self.key}: got {value!r}, expected {self.expected}{hint}")


def parameter(
    default: Any,
    doc: str,
    *,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    choices: Sequence[str] = (),
    live: bool = False,
    of_radius: float = 0.0,
) -> Any:
    """A dataclass field that carries what its `Spec` needs. Angles are in radians, everything else in SI units."""
    doc += f"; default of a robot of {of_radius:g} m, scaled with robot.radius" if of_radius else ""
    kept = {"unit": unit, "low": low, "high": high, "choices": choices, "live": live, "of_radius": of_radius}
    return field(default=default, metadata={"doc": doc, **kept})


@dataclass(frozen=True)
class Parameters:
    """Base of every parameter group. Subclasses are frozen dataclasses and set `group`, the prefix of their keys.

    Raises:
        ParameterError: at construction, when a value does not fit its parameter.
    """

    group: ClassVar[str]

    def __post_init__(self) -> None:
        for name, spec in named_specs(type(self)):  # type: ignore[arg-type]  # mypy takes the hash of instances
            object.__setattr__(self, name, spec.checked(getattr(self, name)))


@cache  # a group is made anew with each change of the drive
def named_specs(group: type[Parameters]) -> tuple[tuple[str, Spec], ...]:
    """Field name and `Spec` of each parameter of a group, in the order they are written."""
    for f in fields(group):
        if f.default is MISSING:
            raise TypeError(f"{group.__name__}.{f.name} has no default")
    return tuple((f.name, Spec(f"{group.group}.{f.name}", default=f.default, **f.metadata)) for f in fields(group))


def specs(group: type[Parameters]) -> tuple[Spec, ...]:
    """The `Spec` of each parameter of a group."""
    return tuple(spec for _, spec in named_specs(group))  # type: ignore[arg-type]  # as above
