"""The line under an animation that says what is drawn in which colour."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

from PIL import Image, ImageDraw, ImageFont

from collplan_ros.pictures.drawing import SMOOTHING, SPEED_COLORS, box, draw_mark, speed_color
from collplan_ros.pictures.palette import FLOOR, FREE, GOAL, PLAN, SCAN, TEXT

SIZE = 12
"""Size of the font [pixel]."""
LINE = 17
"""Height of a line of the legend [pixel]."""
SWATCH, SPACE, MARGIN = 18, 14, 8
"""Width of what is explained, distance to the next entry, and distance from the edge [pixel]."""


class Entry(NamedTuple):
    """An entry: `draw` draws at a pixel (x, y), within SWATCH by LINE at SMOOTHING times the size; `words` name it."""

    words: str
    draw: Callable[[ImageDraw.ImageDraw, float, float], None]


def legend(width: int, entries: Sequence[Entry]) -> Image.Image:
    """Picture of all entries, `width` pixels wide and as high as they need."""
    places, rows = _places(width, entries)
    drawn = Image.new("RGB", (SMOOTHING * width, SMOOTHING * LINE * rows), FLOOR)
    draw = ImageDraw.Draw(drawn)
    for (x, row), entry in zip(places, entries, strict=True):
        entry.draw(draw, SMOOTHING * (x + 0.5 * SWATCH), SMOOTHING * LINE * (row + 0.5))
    image = drawn.reduce(SMOOTHING)
    text = ImageDraw.Draw(image)
    for (x, row), entry in zip(places, entries, strict=True):
        text.text((x + SWATCH + 5, LINE * (row + 0.5)), entry.words, fill=TEXT, font=font(SIZE), anchor="lm")
    return image


def run_entries(top_speed: float) -> list[Entry]:
    """What the animation of a run shows; `top_speed` [m/s] and more have the last colour of a trail."""
    return [
        Entry("free space", lambda draw, x, y: _bar(draw, x, y, FREE, 12)),
        Entry("scan", lambda draw, x, y: _dots(draw, x, y, SCAN)),
        Entry("plan", lambda draw, x, y: _bar(draw, x, y, PLAN, 3)),
        Entry("goal", _goal),
        Entry("deliberate contact", lambda draw, x, y: draw_mark(draw, x, y, 6 * SMOOTHING, True)),
        Entry("other contact", lambda draw, x, y: draw_mark(draw, x, y, 6 * SMOOTHING, False)),
        Entry(f"speed 0 to {top_speed:g} m/s", _speeds),
    ]


@cache
def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """The font of all text in animations."""
    return ImageFont.load_default(size)


def _places(width: int, entries: Sequence[Entry]) -> tuple[list[tuple[float, int]], int]:
    """Left edge [pixel] and row of each entry, and the number of rows."""
    places: list[tuple[float, int]] = []
    x, row = float(MARGIN), 0
    for entry in entries:
        needed = SWATCH + 5 + font(SIZE).getlength(entry.words)
        if x > MARGIN and x + needed > width - MARGIN:
            x, row = float(MARGIN), row + 1
        places.append((x, row))
        x += needed + SPACE
    return places, row + 1


def _bar(draw: ImageDraw.ImageDraw, x: float, y: float, color: str, height: float) -> None:
    half, up = 0.5 * SMOOTHING * SWATCH, 0.5 * SMOOTHING * height
    draw.rectangle([x - half, y - up, x + half, y + up], fill=color)


def _dots(draw: ImageDraw.ImageDraw, x: float, y: float, color: str) -> None:
    for k in range(-2, 3):
        draw.rectangle(box(x + 3.5 * k * SMOOTHING, y, SMOOTHING), fill=color)


def _goal(draw: ImageDraw.ImageDraw, x: float, y: float) -> None:
    draw.ellipse(box(x, y, 7 * SMOOTHING), outline=GOAL, width=2 * SMOOTHING)
    draw.ellipse(box(x, y, 2 * SMOOTHING), fill=GOAL)


def _speeds(draw: ImageDraw.ImageDraw, x: float, y: float) -> None:
    each = SMOOTHING * SWATCH / SPEED_COLORS
    for k in range(SPEED_COLORS):
        left = x + (k - 0.5 * SPEED_COLORS) * each
        draw.rectangle([left, y - 2 * SMOOTHING, left + each, y + 2 * SMOOTHING], fill=speed_color(k))
