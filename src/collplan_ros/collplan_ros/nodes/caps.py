"""Changes of parameters that a robot's node accepts while it runs: none may exceed its caps."""

from collplan_core.parameters import Settings
from collplan_core.parameters.spec import ParameterError

LIVE = ("robot.max_speed",)
"""The parameters of a robot's node that may change while it runs."""


def check_caps(settings: Settings) -> None:
    """Checks that the speed commanded at most is within the cap.

    Raises:
        ParameterError: it is not.
    """
    speed, cap = settings.robot.max_speed, settings.cap.speed
    if speed > cap:
        raise ParameterError(f"robot.max_speed: got {speed:g}, expected at most cap.speed, {cap:g} m/s")
