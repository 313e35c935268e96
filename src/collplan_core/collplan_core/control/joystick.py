"""A joystick with a dead-man button: the velocity that its stick commands, and whether a hand holds the button."""

import math
from dataclasses import dataclass

import numpy as np

from collplan_core.control.follow import saturate
from collplan_core.parameters import Robot, Settings, Teleop
from collplan_core.parameters.spec import ParameterError

RELEASED_FOR = 0.3
"""Time for which a button must be seen released before it counts [s]: joy_node reports all of them released when it
opens a joystick, and those that are pressed a moment later."""


class StickError(ValueError):
    """Error of an unusable joystick, as one without an axis or a button; names what it has and what was expected."""


@dataclass(frozen=True)
class JoyState:
    """State of a joystick.

    Attributes:
        axes: each in [-1, 1], positive forward, to the left and for a turn to the left.
        buttons: whether each is pressed.
    """

    axes: tuple[float, ...]
    buttons: tuple[bool, ...]

    def pressed(self, button: int) -> bool:
        """Returns whether a button is pressed.

        Raises:
            StickError: there is no such button.
        """
        if button >= len(self.buttons):
            raise StickError(f"buttons: got {len(self.buttons)}, expected one of index {button}")
        return self.buttons[button]

    def axis(self, index: int) -> float:
        """Returns the position of an axis.

        Raises:
            StickError: there is no such axis, or it is no number.
        """
        if index >= len(self.axes):
            raise StickError(f"axes: got {len(self.axes)}, expected one of index {index}")
        if not math.isfinite(self.axes[index]):
            raise StickError(f"axes[{index}]: got {self.axes[index]}, expected a finite number")
        return self.axes[index]


@dataclass(frozen=True)
class DebouncedButton:
    """State of a button that a hand holds: the dead-man button, or the one that resumes.

    A button that is pressed from the start, or after the joystick was silent, may be stuck. It counts only after it was
    seen released for RELEASED_FOR without a press.

    Attributes:
        was_released: whether it was seen released for RELEASED_FOR.
        holds: whether it is pressed, and counts.
        since: time since which it is seen released [s]; infinite where it is pressed, or not seen yet.
    """

    was_released: bool = False
    holds: bool = False
    since: float = math.inf

    def after(self, pressed: bool, now: float) -> "DebouncedButton":
        """The state after the button was seen pressed or released at `now` [s]."""
        since = math.inf if pressed else min(self.since, now)
        was_released = self.was_released or now - since >= RELEASED_FOR
        return DebouncedButton(was_released, pressed and was_released, since)


def check_stick(settings: Settings) -> None:
    """Checks that no axis and no button has two functions.

    Raises:
        ParameterError: one has.
    """
    teleop = settings.teleop
    axes = {name: getattr(teleop, name) for name in ("forward_axis", "left_axis", "turn_axis")}
    buttons = {name: getattr(teleop, name) for name in ("dead_man_button", "stop_button", "resume_button")}
    for chosen in (axes, buttons):
        if len(set(chosen.values())) < len(chosen):
            got = ", ".join(f"teleop.{name} {index}" for name, index in chosen.items())
            raise ParameterError(f"{got}: expected another one for each")


def velocity_of(stick: JoyState, teleop: Teleop, robot: Robot) -> tuple[np.ndarray, float]:
    """The velocity (2,) [m/s, body frame] and the yaw rate [rad/s] that a stick commands.

    The deadzone is a disc for driving: the direction is the stick's. From its edge on the speed grows from zero.

    Raises:
        StickError: an axis is not there, or no number.
    """
    drive = saturate(np.array([stick.axis(teleop.forward_axis), stick.axis(teleop.left_axis)]), 1.0)
    turn = min(max(stick.axis(teleop.turn_axis), -1.0), 1.0)
    speed = teleop.speed_share * robot.max_speed * _beyond(math.hypot(*drive), teleop.deadzone)
    yaw_rate = teleop.turn_share * robot.max_yaw_rate * _beyond(abs(turn), teleop.deadzone)
    return speed * drive / max(math.hypot(*drive), 1e-9), math.copysign(yaw_rate, turn)


def _beyond(way: float, deadzone: float) -> float:
    """Returns how far a stick is beyond its deadzone, as a share of the range beyond it."""
    return max(way - deadzone, 0.0) / (1.0 - deadzone)
