"""A constant of the robot with its interval, and why there may be none."""

from dataclasses import dataclass

LEVEL = 0.95
"""Level of the intervals."""


class TooLittle(ValueError):
    """Error of runs that do not determine the constants; the message names what is missing."""


class Unexplained(ValueError):
    """Error of poses that no constants explain; the message names the figure and what was expected."""


@dataclass(frozen=True)
class FittedConstant:
    """One constant.

    Attributes:
        value: the estimate.
        low, high: ends of its 95 % interval.
        basis: description of the data behind it, for a reader.
    """

    value: float
    low: float
    high: float
    basis: str

    def holds(self, value: float) -> bool:
        """Returns whether the interval holds `value`."""
        return self.low <= value <= self.high
