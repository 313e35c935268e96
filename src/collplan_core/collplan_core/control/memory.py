"""The controller's memory between two periods."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(frozen=True, eq=False)
class ControllerMemory:
    """The memory that one control period hands to the next.

    Attributes:
        integral: (2,) integral of the position error, as a velocity [m/s, world frame].
        heading: yaw that is held [rad]; None until the first pose is seen.
        follower: what the planner's own way to follow its plans keeps; None at first.
    """

    integral: np.ndarray = field(default_factory=lambda: np.zeros(2))
    heading: float | None = None
    follower: Any = None
