"""The robot as the optimum has it."""

from dataclasses import dataclass

from collplan_core.parameters import Settings


@dataclass(frozen=True)
class Disc:
    """A disc that accelerates as it likes up to a limit, at once and without noise: the real robot can do less."""

    radius: float  # [m]
    max_speed: float  # of the velocity's length [m/s]
    max_acceleration: float  # of the acceleration's length [m/s^2]
    goal_tolerance: float  # it has arrived where its centre is this near the goal, at any velocity [m]


def disc_of(settings: Settings) -> Disc:
    """The disc with the radius, the limits and the tolerance of a robot."""
    robot = settings.robot
    return Disc(robot.radius, robot.max_speed, robot.max_acceleration, settings.planner.goal_tolerance)
