"""Movers: discs and people that walk along a way through a world."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from collplan_core.validation import finite

WAY_FORM = "expected at least one way point [x, y] [m], no two in a row equal unless times are given"

NUMBERS = {"radius": "above 0 [m]", "speed": "above 0 [m/s]", "delay": "from 0 [s]", "pause": "from 0 [s]"}
DISC, PERSON = "disc", "person"
KINDS = DISC, PERSON
TIMES_FORM = "expected as many rising times from 0 [s] as way points"
HIP = 0.10
"""Distance of each leg of a person from the line that the person walks on [m]."""


@dataclass(frozen=True, eq=False)
class Mover:
    """A disc, or a person on two legs, that walks straight from way point to way point.

    Raises:
        ValueError: at construction; the message names the key, the value and what was expected.
    """

    radius: float  # radius, of a person that of each leg [m]
    way: np.ndarray  # (k, 2) its way points; with one alone it stands [m]
    speed: float  # speed of walking [m/s]
    to_and_fro: bool = True
    """Walks back from the last way point to the first, and so on; otherwise it stays at the last."""
    delay: float = 0.0  # time for which it stands at the first way point before it sets out [s]
    pause: float = 0.0  # time for which it stands at each way point that it comes to [s]
    rounds: int = 0  # number of walks there and back after which it stays at the first way point; with 0 it never does
    kind: str = DISC  # "disc", or "person"
    times: np.ndarray | None = None
    """(k,) when it is at each way point [s], as of a recorded walk; then `speed` is that of its gait alone, and it
    neither pauses nor comes back."""

    def __post_init__(self) -> None:
        for key, expected in NUMBERS.items():
            value = getattr(self, key)
            # Python takes true for the number 1
            is_number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
            if not (is_number and math.isfinite(value) and (value > 0.0 or (value == 0.0 and "from" in expected))):
                raise ValueError(f"{key}: got {value!r:.80}, expected a number {expected}")
        if not isinstance(self.to_and_fro, bool):
            raise ValueError(f"to_and_fro: got {self.to_and_fro!r:.80}, expected true or false")
        if type(self.rounds) is not int or self.rounds < 0:
            raise ValueError(f"rounds: got {self.rounds!r:.80}, expected a whole number from 0")
        if self.kind not in KINDS:
            raise ValueError(f"kind: got {self.kind!r:.80}, expected one of {', '.join(KINDS)}")
        way = finite("way", self.way, (None, 2), WAY_FORM)
        if len(way) == 0 or (self.times is None and (np.hypot(*np.diff(way, axis=0).T) < 1e-9).any()):
            raise ValueError(f"way: got {way.tolist()!r:.80}, {WAY_FORM}")
        way.flags.writeable = False
        object.__setattr__(self, "way", way)
        if self.times is not None:
            times = finite("times", self.times, (len(way),), TIMES_FORM)
            if times[0] < 0.0 or (np.diff(times) <= 0.0).any():
                raise ValueError(f"times: got {times.tolist()!r:.80}, {TIMES_FORM}")
            object.__setattr__(self, "times", times)
            object.__setattr__(self, "to_and_fro", False)

    @property
    def reach(self) -> float:
        """Radius of the disc around its place that holds all of it [m]."""
        return self.radius if self.kind == DISC else HIP + self.radius

    @cached_property
    def schedule(self) -> tuple[np.ndarray, np.ndarray]:
        """Times (n,) from setting out on [s] and places (n, 2) [m] between which it walks evenly or stands.

        To and fro it lasts until it would set out again.
        """
        if self.times is not None:
            return self.times, self.way
        way = np.vstack([self.way, self.way[-2::-1]]) if self.to_and_fro and len(self.way) > 1 else self.way
        leaves = np.cumsum(np.hypot(*np.diff(way, axis=0).T) / self.speed + self.pause)
        times = np.column_stack([leaves - self.pause, leaves]).ravel()
        return np.concatenate([[0.0], times]), np.vstack([way[:1], np.repeat(way[1:], 2, axis=0)])


def place_at(mover: Mover, time: float) -> tuple[float, float]:
    """The place of a mover that nothing hinders, at a time from the beginning of the run on [s]."""
    times, places = mover.schedule
    since = since_set_out(mover, time)
    return float(np.interp(since, times, places[:, 0])), float(np.interp(since, times, places[:, 1]))


def turned(mover: Mover, time: float) -> float:
    """The time at which a mover that walks to and fro is at the place of `time` [s] and walks the other way."""
    whole, since = float(mover.schedule[0][-1]), since_set_out(mover, time)
    return max(time, mover.delay) - since + (whole - mover.pause - since) % whole


def since_set_out(mover: Mover, time: float) -> float:
    """Time since it set out on the round that it walks [s]."""
    since, whole = max(time - mover.delay, 0.0), float(mover.schedule[0][-1])
    if not mover.to_and_fro or whole == 0.0 or 0.0 < mover.rounds * whole <= since:
        return since
    return since % whole
