"""The records of what a recording shows."""

from dataclasses import dataclass, field
from typing import Any

from collplan_core.parameters import all_specs
from collplan_core.parameters.spec import ParameterError

OK, DOUBTFUL, WRONG = "ok", "doubtful", "WRONG"


@dataclass(frozen=True)
class Found:
    """A value of a parameter, and within what the truth lies in 95 of 100; None where it is a name or a choice."""

    value: Any
    uncertainty: float | None = None


@dataclass(frozen=True, eq=False)
class Findings:
    """Parameters found, and those that the motion did not show, each with the motion that would."""

    found: dict[str, Found] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    # how the motion measured is turned [rad], mirrored and scaled against the commands; None where not shown
    axes: dict[str, Any] = field(default_factory=lambda: {"turned": None, "mirrored": None, "scale": None})
    remarks: list[tuple[str, str]] = field(default_factory=list)  # what else is to be said, each with its verdict

    @property
    def values(self) -> dict[str, Any]:
        """The values alone."""
        return {key: each.value for key, each in self.found.items()}

    def check(self) -> None:
        """Moves values that the parameters do not take to what is missing."""
        for key, each in list(self.found.items()):
            try:
                all_specs()[key].checked(each.value)
            except ParameterError as error:
                del self.found[key]
                self.missing[key] = str(error)
