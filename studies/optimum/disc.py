"""The robot as the optimum has it."""

from dataclasses import dataclass

from collplan_core.parameters import Settings


@dataclass(frozen=True)
class Disc:
    """A disc that accelerates as it likes up to a limit, at once and without noise: the real robot can do less.

    Attributes:
        radius: [m].
        max_speed, max_acceleration: limits of the length of either vector [m/s], [m/s^2].
        goal_tolerance: it has arrived where its centre is this near the goal, at any velocity [m].
    """

    radius: float
    max_speed: float
    max_acceleration: float
    goal_tolerance: float


def disc_of(settings: Settings) -> Disc:
    """The disc with the radius, the limits and the tolerance of a robot."""
    robot = settings.robot
    return Disc(robot.radius, robot.max_speed, robot.max_acceleration, settings.planner.goal_tolerance)
