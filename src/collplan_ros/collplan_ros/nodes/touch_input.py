"""Reads the touches that a base reports, by `base.touch`: contacts, sides of hits, or accelerations."""

import math
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from rclpy.clock import Clock

from collplan_core.parameters import Base, Settings
from collplan_core.parameters.spec import ParameterError
from collplan_core.plane import rotate
from collplan_core.sensing.felt_touch import change_by_touch
from collplan_core.state import State
from collplan_ros.messages.qos import EVENT
from collplan_ros.node_kit.clock import seconds
from collplan_ros.node_kit.input_watch import EVENT as EVENT_INPUT
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.nodes.felt_impacts import FeltImpacts

NONE = "none"
MESSAGES = {"bool": ("std_msgs", "Bool"), "hit": ("robomaster_msgs", "ArmorHit"), "imu": ("sensor_msgs", "Imu")}
"""Package and message of each value of `base.touch` but NONE."""
COLLISION = 0
"""ArmorHit.type of a hit; others are the light of another robot's gun."""
SIDES = {1: (-1.0, 0.0), 2: (1.0, 0.0), 4: (0.0, 1.0), 8: (0.0, -1.0)}
"""Direction to the obstacle, x forward, y left, of each bit of ArmorHit.location."""
SAME = 0.15
"""Touches that follow one within this time are the same one [s]."""
NOWHERE = np.zeros(2)
"""Direction of what is no touch."""


def touch_type(base: Base) -> type:
    """The message class of `base.touch`.

    Raises:
        ParameterError: its package is not installed.
    """
    package, name = MESSAGES[base.touch]
    try:
        found: type = getattr(import_module(f"{package}.msg"), name)
    except ImportError:
        raise ParameterError(
            f"base.touch: got {base.touch!r}, expected one whose messages are installed; {name} of {package} is not"
        ) from None
    return found


def _towards_of_hit(message: Any, base: Base) -> np.ndarray:
    sides = [side for bit, side in SIDES.items() if message.location & bit] if message.type == COLLISION else []
    total = np.sum(sides, axis=0) if sides else NOWHERE
    return total / math.hypot(*total) if total.any() else NOWHERE


def _towards_of_spike(message: Any, base: Base) -> np.ndarray:
    pushed = np.array([message.linear_acceleration.x, message.linear_acceleration.y])
    size = float(np.hypot(*pushed))
    return -pushed / size if size > base.touch_acceleration else NOWHERE


def _towards_of_contact(message: Any, base: Base) -> np.ndarray | None:
    return None if message.data else NOWHERE


TOWARDS: dict[str, Callable[[Any, Base], np.ndarray | None]] = {
    "bool": _towards_of_contact,
    "hit": _towards_of_hit,
    "imu": _towards_of_spike,
}
"""Direction to the obstacle in the body frame by `base.touch`; None where it is not felt, NOWHERE without a touch."""


class TouchInput:
    """Takes the messages of a base, and publishes the impacts in them.

    Attributes:
        published: impacts published.
        missed: touches without a pose, or of a robot that did not move into anything.
    """

    def __init__(self, inputs: Inputs, felt: FeltImpacts, settings: Settings, clock: Clock) -> None:
        """Subscribes through `inputs`, publishes through `felt`; `clock` is that of the touches."""
        self.published = self.missed = 0
        self._settings, self._clock, self._felt = settings, clock, felt
        self._touched, self._last = False, -math.inf
        base = settings.base
        inputs.listen(touch_type(base), base.touch_topic, self._take, EVENT, EVENT_INPUT)

    def _take(self, message: Any) -> None:
        towards = TOWARDS[self._settings.base.touch](message, self._settings.base)
        before, self._touched = self._touched, towards is not NOWHERE
        now = seconds(self._clock)
        if not self._touched or before or now - self._last < SAME:
            return
        self._last = now

        def change_at(state: State) -> np.ndarray:
            ahead = None if towards is None else np.array(rotate(*towards.tolist(), state.yaw))
            return change_by_touch(state.velocity, ahead, self._settings.rebound.restitution)

        published = self._felt.publish(0.0, change_at)
        self.published += published
        self.missed += not published
