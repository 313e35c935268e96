"""Writing frames as a GIF, in colours that are the same in every picture of the project."""

from collections.abc import Sequence
from itertools import chain
from pathlib import Path

from PIL import Image, ImageColor

from collplan_ros.pictures.drawing import SPEED_COLORS, speed_color
from collplan_ros.pictures.palette import IN_ANIMATIONS

N_COLORS = 192
"""Colours of a GIF."""
SAMPLED = 12
"""Frames from which the colours beside the fixed ones are taken: the mixtures at edges."""
MOST = 256
"""Entries of a GIF's palette."""


def save_gif(path: Path, frames: Sequence[Image.Image], period: float, last: float) -> None:
    """Writes an endless GIF of frames shown for `period` [s] each, the last one for `last` [s]."""
    palette = _palette(frames)
    reduced = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    durations = [round(1e3 * period)] * (len(frames) - 1) + [round(1e3 * last)]
    reduced[0].save(path, save_all=True, append_images=reduced[1:], duration=durations, loop=0, optimize=True)


def _palette(frames: Sequence[Image.Image]) -> Image.Image:
    """An image whose palette holds the fixed colours, whatever little of them a frame shows, and the commonest others.

    The others come from frames of all parts of the run: what moves is hidden in some.
    """
    fixed = [*map(_rgb, IN_ANIMATIONS), *map(speed_color, range(SPEED_COLORS))]
    chosen = [frames[k * (len(frames) - 1) // max(SAMPLED - 1, 1)] for k in range(SAMPLED)]
    width, height = chosen[0].size
    together = Image.new("RGB", (width, height * len(chosen)))
    for k, frame in enumerate(chosen):
        together.paste(frame, (0, k * height))
    others = together.quantize(N_COLORS - len(fixed)).getpalette() or []
    values = [*chain.from_iterable(fixed), *others[: 3 * (N_COLORS - len(fixed))]]
    palette = Image.new("P", (1, 1))
    # entries that nothing uses repeat the first: Pillow would fill them with black
    palette.putpalette(values + list(fixed[0]) * (MOST - len(values) // 3))
    return palette


def _rgb(color: str) -> tuple[int, int, int]:
    red, green, blue = ImageColor.getrgb(color)[:3]
    return red, green, blue
