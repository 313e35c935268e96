"""The largest acceleration that a robot has shown in its poses: what it brakes by again is no impact.

An impact is over within one span. What lasts for two in a row, beyond the noise, the wheels have made.
"""

import math
from typing import NamedTuple

SPAN, PARTS = 0.12, 3
"""Time between two velocities that are compared [s], and the number of times that one is kept within it: an impact is
found, and begins them anew, before two spans are over."""
CERTAIN = 4.0
"""Deviations of the noise that an acceleration must exceed."""


class Shown(NamedTuple):
    """What the velocities of a track have shown."""

    most: float = 0.0  # largest acceleration that lasted [m/s^2]
    velocities: tuple[tuple[float, float, float], ...] = ()  # the last ones kept, of two spans: stamp [s], vx, vy [m/s]

    def anew(self) -> "Shown":
        """What is left where something else has changed the velocity."""
        return Shown(self.most)

    def with_velocity(self, stamp: float, vx: float, vy: float, deviation: float) -> "Shown":
        """What one more velocity [m/s] with a deviation by axis [m/s] shows as well."""
        if self.velocities and 0.0 <= stamp - self.velocities[-1][0] < SPAN / PARTS - 1e-3:
            return self
        kept = tuple(each for each in self.velocities if 0.0 < stamp - each[0] < 3.0 * SPAN)[-2 * PARTS :]
        kept = *kept, (stamp, vx, vy)
        if len(kept) <= 2 * PARTS:
            return Shown(self.most, kept)
        (at, ux, uy), (middle, wx, wy) = kept[0], kept[PARTS]
        first = (wx - ux) / (middle - at), (wy - uy) / (middle - at)
        then = (vx - wx) / (stamp - middle), (vy - wy) / (stamp - middle)
        larger = max(math.hypot(*first), math.hypot(*then), 1e-9)
        lasted = (first[0] * then[0] + first[1] * then[1]) / larger
        return Shown(max(self.most, lasted - CERTAIN * math.sqrt(2.0) * deviation / SPAN), kept)


NOTHING_SHOWN = Shown()
