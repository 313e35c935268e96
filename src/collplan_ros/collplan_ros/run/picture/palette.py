"""Colours of pictures: where a thing is in the live page too, the page's on light ground."""

import numpy as np

OBSTACLE, WALL, GOAL, PLAN = "#c9d1db", "#46566b", "#00855f", "#0072b2"
DELIBERATE, FORESEEN, OTHER, OUTLINE = "#d55e00", "#e69f00", "#111111", "#ffffff"

SLOW_TO_FAST = ("#0d0887", "#5c01a6", "#9c179e", "#cc4778", "#ed7953", "#fdb42f", "#f0f921")
"""Colours of speeds (plasma): their lightness rises all the way, so that they are read without colours too."""
LIGHTEST = 0.86
"""Share of them that is used: the light end cannot be seen on light ground."""


def speed_colors(shares: np.ndarray) -> np.ndarray:
    """Red, green and blue (n, 3), from 0 to 255, of speeds (n,) as shares of the highest, from 0 to 1."""
    stops = np.array([list(bytes.fromhex(stop[1:])) for stop in SLOW_TO_FAST])
    at = LIGHTEST * np.clip(shares, 0.0, 1.0) * (len(stops) - 1)
    return np.column_stack([np.interp(at, np.arange(len(stops)), channel) for channel in stops.T])
