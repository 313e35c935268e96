"""Reads the touches that a base reports, by `base.touch`: contacts, sides of hits, or accelerations."""

import math
from collections import deque
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from rclpy.clock import Clock

from collplan_core.control.runaway import MOVES
from collplan_core.parameters import Base, Settings
from collplan_core.parameters.spec import ParameterError
from collplan_core.plane import rotate
from collplan_core.poses.felt_touch import change_by_touch
from collplan_core.state import State
from collplan_ros.messages.qos import EVENT
from collplan_ros.node_kit.clock import seconds
from collplan_ros.node_kit.inputs import EVENT as EVENT_INPUT
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.nodes.felt_impacts import FeltImpacts

NONE = "none"
MESSAGES = {"bool": ("std_msgs", "Bool"), "hit": ("robomaster_msgs", "ArmorHit"), "imu": ("sensor_msgs", "Imu")}
"""Package and message of each value of `base.touch` but NONE."""
COLLISION = 0
"""ArmorHit.type of a hit; others are the light of another robot's gun."""
SIDES = {1: (-1.0, 0.0), 2: (1.0, 0.0), 4: (0.0, 1.0), 8: (0.0, -1.0)}
"""Direction to the obstacle, x forward, y left, of each bit of ArmorHit.location."""
GRAVITY = 9.81
KEPT, ENOUGH = 400, 40
"""Accelerations looked at together, and those below which nothing is said."""
SPEED, ALIKE = 0.1, 0.8
"""Spread of the velocity that shows in which unit accelerations are [m/s], and how well both must agree."""
ASIDE = 3
"""Touches aside of the motion from which on, where they are most of all, the sensor is taken for turned."""
CHATTER, LONG = 5, 5.0
"""Touches within SAME of another from which on a sensor chatters, and duration of one that does not end [s]."""
SAME = 0.15
"""Touches that follow one within this time are the same one [s]."""
NOWHERE = np.zeros(2)
"""Direction of what is no touch."""


def touch_type(base: Base) -> type:
    """The message class of `base.touch`; ParameterError: its package is not installed."""
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
    # a bus error reads NaN or inf
    return -pushed / size if base.touch_acceleration < size < math.inf else NOWHERE


def why_unlike_imu(accelerations: np.ndarray) -> str:
    """Returns what accelerations (n, 3) [m/s^2] show of a sensor whose hits are not felt, or at a wrong side; or ""."""
    finite = accelerations[np.isfinite(accelerations).all(axis=1)]
    if 2 * len(finite) < len(accelerations):
        return "most accelerations are not finite"
    x, y, z = np.median(finite, axis=0).tolist()
    weight = math.hypot(x, y, z)
    if weight > 0.5 and not 0.8 * GRAVITY < weight < 1.2 * GRAVITY:
        unit = "in g? " if 0.8 < weight < 1.2 else ""
        return f"at rest it reads {weight:.3g}, {unit}expected {GRAVITY:g} m/s^2, or 0 where gravity is taken out"
    if weight > 0.5 and z < 0.9 * weight:
        return f"gravity is at {x:.1f}, {y:.1f}, {z:.1f} m/s^2, expected along z: upside down, or tilted?"
    return ""


def why_other_unit(readings: np.ndarray) -> str:
    """What accelerations show beside the velocities of poses where gravity is taken out; or "".

    The readings are (n, 5) time [s], rising, acceleration [m/s^2] and velocity [m/s] in the body frame.
    """
    rows = readings[np.isfinite(readings).all(axis=1)]
    if len(rows) < ENOUGH:
        return ""
    gained = 0.5 * (rows[1:, 1:3] + rows[:-1, 1:3]) * np.diff(rows[:, :1], axis=0)
    both = np.hstack([gained.cumsum(axis=0), rows[1:, 3:]])
    # an offset of the sensor grows evenly
    even = np.column_stack([np.ones(len(both)), rows[1:, 0] - rows[0, 0]])
    read, driven = np.hsplit(both - even @ np.linalg.lstsq(even, both)[0], 2)
    moved, agree = float((driven**2).sum()), float((read * driven).sum())
    share = agree / moved if moved > len(rows) * SPEED**2 else 1.0
    if 0.5 < share < 2.0 or agree < ALIKE * math.sqrt(moved * float((read**2).sum())):
        return ""
    unit = "in g? " if 0.8 < share * GRAVITY < 1.2 else ""
    return f"it reads {share:.2g} of the accelerations that the poses show, {unit}expected m/s^2"


def _towards_of_contact(message: Any, base: Base) -> np.ndarray | None:
    return None if message.data else NOWHERE


TOWARDS: dict[str, Callable[[Any, Base], np.ndarray | None]] = {
    "bool": _towards_of_contact,
    "hit": _towards_of_hit,
    "imu": _towards_of_spike,
}
"""Direction to the obstacle in the body frame by `base.touch`; None where it is not felt, NOWHERE without a touch."""


class TouchInput:
    """Takes the messages of a base, and publishes the impacts in them."""

    def __init__(self, inputs: Inputs, felt: FeltImpacts, settings: Settings, clock: Clock) -> None:
        """Subscribes through `inputs`, publishes through `felt`; `clock` is that of the touches."""
        self.published = self.missed = 0
        """Impacts published, and touches without a pose or of a robot that did not move into anything."""
        self._settings, self._clock, self._felt = settings, clock, felt
        self._touched, self._last = False, -math.inf
        self._aside = self._bounced = 0
        self._since = math.inf
        self._accelerations = deque[tuple[float, ...]](maxlen=KEPT)
        self._driven = deque[tuple[float, ...]](maxlen=KEPT)
        base = settings.base
        inputs.listen(touch_type(base), base.touch_topic, self._take, EVENT, EVENT_INPUT)

    def _take(self, message: Any) -> None:
        base, now = self._settings.base, seconds(self._clock)
        if base.touch == "imu":
            read = message.linear_acceleration
            self._accelerations.append((read.x, read.y, read.z))
            state = self._felt.newest
            driven = (math.nan, math.nan) if state is None else rotate(*state.velocity.tolist(), -state.yaw)
            self._driven.append((now, read.x, read.y, *driven))
        towards = TOWARDS[base.touch](message, base)
        before, self._touched = self._touched, towards is not NOWHERE
        last, self._last = self._last, now if self._touched else self._last
        if not self._touched or before:
            self._since = min(self._since, now) if self._touched else math.inf
            return
        if now - last < SAME:  # a contact that bounces is felt once, however long
            self._bounced += 1
            return

        def change_at(state: State) -> np.ndarray:
            ahead = None if towards is None else np.array(rotate(*towards.tolist(), state.yaw))
            change = change_by_touch(state.velocity, ahead, self._settings.rebound.restitution)
            self._aside += not change.any() and math.hypot(*state.velocity.tolist()) > MOVES
            return change

        published = self._felt.publish(0.0, change_at)
        self.published += published
        self.missed += not published

    @property
    def why_doubtful(self) -> str:
        """What the messages show of a sensor that is not as it should be, or ""."""
        topic = self._settings.base.touch_topic
        if len(self._accelerations) >= ENOUGH:
            unlike = why_unlike_imu(np.array(self._accelerations)) or why_other_unit(np.array(self._driven))
            if unlike:
                return f"{topic}: {unlike}"
        if seconds(self._clock) - self._since > LONG:
            return f"{topic}: touched for over {LONG:g} s: is the contact stuck, or inverted?"
        if self._bounced >= CHATTER and self._bounced > self.published:
            return f"{topic}: {self._bounced} touches within {SAME:g} s of another: does the contact chatter?"
        if self._aside >= ASIDE and self._aside > self.published:
            return f"{topic}: {self._aside} touches aside of the motion, {self.published} felt: is the sensor turned?"
        return ""
