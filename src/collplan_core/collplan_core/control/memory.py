"""The controller's memory between two periods."""

import math
from dataclasses import dataclass, field

import numpy as np

from collplan_core.command import FREE_SPACE
from collplan_core.control.references import WAITING


@dataclass(frozen=True, eq=False)
class ManeuverCourse:
    """One plan as the controller follows it.

    Attributes:
        stamp: stamp of the plan [s].
        maneuver: the maneuver for the contact that the plan's path runs into; FREE_SPACE where there is none.
        contact_point: engaging point p_c (2,) [m], or None.
        release_point: disengaging point p_d (2,) [m], or None.
        contact_path: reference of the maneuver (n, 2) [m], or None.
    """

    stamp: float = math.nan
    maneuver: str = FREE_SPACE
    contact_point: np.ndarray | None = None
    release_point: np.ndarray | None = None
    contact_path: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class ControllerMemory:
    """The memory that one control period hands to the next.

    Attributes:
        integral: (2,) integral of the position error, as a velocity [m/s, world frame].
        heading: yaw that is held [rad]; None until the first pose is seen.
        course: the course of the plan in force.
        stage: stage of its maneuver, phi of the paper's III-B: waiting, engaged or released.
    """

    integral: np.ndarray = field(default_factory=lambda: np.zeros(2))
    heading: float | None = None
    course: ManeuverCourse = field(default_factory=ManeuverCourse)
    stage: str = WAITING
