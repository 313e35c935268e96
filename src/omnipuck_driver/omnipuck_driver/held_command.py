"""The last velocity command, and how long it holds."""

from dataclasses import dataclass

from omnipuck_driver.session import WheelCommand


@dataclass(frozen=True)
class HeldCommand:
    """Wheel speeds [rad/s] and the time of their command [s, local clock]."""

    wheels: tuple[float, ...]
    given: float

    def wheel_command(self, now: float, longest_age: float) -> WheelCommand | None:
        """The wheel command to send at `now` [s]; None once the command is older than `longest_age` [s]."""
        age = now - self.given
        return WheelCommand(self.wheels, age, longest_age - age) if age < longest_age else None
